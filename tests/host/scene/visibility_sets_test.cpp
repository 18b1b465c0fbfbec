#include "host/core/scene/visibility_sets.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "host/core/scene/edit.hpp"
#include "host/core/scene/occluders.hpp"

namespace simuli {
namespace {

/// Returns three chunks of 100 m along x, defined by positions 5 m apart.
std::vector<VisibilitySet> three_chunks() {
  std::vector<VisibilitySet> visibility_sets(3);
  for (std::size_t k = 0; k < 3; ++k) {
    for (int i = 0; i <= 20; ++i) {
      visibility_sets[k].path_m.emplace_back(100.0 * static_cast<double>(k) + 5.0 * i, 0.0, 0.0);
    }
  }
  return visibility_sets;
}

TEST(VisibilitySets, AreVisibleFromTheirChunkAndFadeBehindIt) {
  const std::vector<VisibilitySet> visibility_sets = three_chunks();
  const auto shares = [&](double x, double y) { return visibility_shares(visibility_sets, {x, y, 1.5}); };
  const auto expect = [&](double x, double y, double first, double second, double third) {
    const std::vector<double> found = shares(x, y);
    ASSERT_EQ(found.size(), 3U);
    EXPECT_NEAR(found[0], first, 0.02) << x;
    EXPECT_NEAR(found[1], second, 0.02) << x;
    EXPECT_NEAR(found[2], third, 0.02) << x;
  };
  expect(-30.0, 0.0, 1.0, 0.0, 0.0);  // before the drive, too
  expect(50.0, 0.0, 1.0, 0.0, 0.0);
  expect(52.5, 3.0, 1.0, 0.0, 0.0);
  expect(100.0, 0.0, 1.0, 1.0, 0.0);
  expect(102.0, 0.0, 0.75, 1.0, 0.0);  // the camera is 1.5 m above the trajectory
  expect(105.5, 0.0, 0.0, 1.0, 0.0);
  expect(150.0, 3.0, 0.0, 1.0, 0.0);
  expect(400.0, 0.0, 0.0, 0.0, 1.0);
  std::vector<double> before = shares(-20.0, 2.0);
  for (double x = -20.0; x <= 330.0; x += 0.25) {
    const std::vector<double> now = shares(x, 2.0);
    EXPECT_EQ(*std::max_element(now.begin(), now.end()), 1.0) << x;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(now[k], before[k], 0.063) << x;
    before = now;
  }
  EXPECT_TRUE(visibility_shares({}, {0.0, 0.0, 0.0}).empty());
  const VisibilitySet place{{{3.0, 0.0, 0.0}}};
  EXPECT_EQ(visibility_shares({place}, {900.0, 0.0, 0.0}), std::vector<double>{1.0});
}

TEST(VisibilitySets, AreOwnersBetweenActorsAndOccluders) {
  Scene scene;
  scene.origin = {1000.0, 0.0, 0.0};
  scene.visibility_sets = three_chunks();
  for (VisibilitySet& visibility_set : scene.visibility_sets) {
    for (Eigen::Vector3d& place : visibility_set.path_m) place += scene.origin;
  }
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  for (const double time_s : {0.0, 2.0}) car.track.push_back({time_s, {}});
  scene.actors = {car};
  scene.occluders = {car};
  ASSERT_EQ(most_numbers(scene), 6U);
  EXPECT_EQ(number_of_visibility_set(scene, 0), 2U);
  EXPECT_EQ(number_of_visibility_set(scene, 2), 4U);
  EXPECT_EQ(disoccluded_number(scene, 0), 5U);
  const auto there = [&](const std::optional<Eigen::Vector3d>& eye) {
    std::vector<bool> out;
    for (const ActorView& view : owners_during(scene, scene.actors, 1.0, 1.0, eye))
      out.push_back(view.is_there);
    return out;
  };
  EXPECT_EQ(there(Eigen::Vector3d(1250.0, 0.0, 0.0)),
            (std::vector<bool>{true, false, false, true, true, false}));
  EXPECT_EQ(there(Eigen::Vector3d(1101.0, 0.0, 0.0)),
            (std::vector<bool>{true, true, true, false, true, false}));
  EXPECT_EQ(there(std::nullopt), (std::vector<bool>{true, true, true, true, true, false}));
  const auto views = owners_during(scene, scene.actors, 1.0, 1.0, Eigen::Vector3d(1101.0, 0.0, 0.0));
  EXPECT_NEAR(views[1].share, 0.75, 1e-9);
  EXPECT_EQ(views[2].share, 1.0);

  // Programs without visibility sets receive each particle once, from the nearest visibility set.
  scene.camera = GaussianSet(SetKind::kCamera, 0, 9);
  scene.camera.rotation().col(0).setOnes();
  scene.camera.mean().col(0) << 0.0F, 1.0F, 50.0F, 150.0F, 250.0F, 5.0F, 150.0F, 99.0F, 201.0F;
  scene.camera.actor = {0, 1, 2, 3, 4, disoccluded_number(scene, 0), 2, 3, 3};
  EXPECT_EQ(background_of(scene, SetKind::kCamera).size(), 4);
  EXPECT_EQ(background_of(scene, SetKind::kCamera).mean().col(0).sum(), 450.0F);
  EXPECT_EQ(moment_of(scene, SetKind::kCamera, 1.0).size(), 6);
}

TEST(VisibilitySets, HaveOccludersOfTheirOwn) {
  Scene scene;
  scene.visibility_sets = three_chunks();
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  for (const double time_s : {0.0, 2.0}) car.track.push_back({time_s, {}});
  scene.actors = {car};
  scene.occluders = {car};
  scene.visibility_sets[1].occluders = {car};
  scene.visibility_sets[2].occluders = {car};
  ASSERT_EQ(most_numbers(scene), 10U);
  ASSERT_EQ(occluders_of(scene).size(), 3U);
  EXPECT_FALSE(occluders_of(scene)[0].visibility_set.has_value());
  EXPECT_EQ(occluders_of(scene)[2].visibility_set, 2U);
  const OwnerNumbers numbers = owner_numbers(scene);
  const std::optional<std::size_t> none;
  for (std::uint32_t number = 0; number <= 11; ++number) {
    EXPECT_EQ(numbers.is_actor(number), number == 1) << number;
    EXPECT_EQ(numbers.visibility_set_of(number),
              number >= 2 && number <= 4 ? std::optional<std::size_t>(number - 2) : none);
    EXPECT_EQ(numbers.occluder_of(number),
              number >= 5 && number <= 10 ? std::optional<std::size_t>((number - 5) / 2) : none);
  }
  const auto shares = [&](const std::vector<Actor>& actors, const std::optional<Eigen::Vector3d>& eye) {
    std::vector<double> out;
    for (const ActorView& view : owners_during(scene, actors, 1.0, 1.0, eye))
      out.push_back(view.is_there ? view.share : 0.0);
    return out;
  };
  const Eigen::Vector3d eye(199.0, 0.0, 0.0);
  const std::vector<double> recorded = shares(scene.actors, eye);
  EXPECT_EQ(recorded[0], 1.0);
  EXPECT_NEAR(recorded[3], 0.75, 1e-9);
  EXPECT_EQ((std::vector<double>(recorded.begin() + 4, recorded.end())),
            (std::vector<double>{1.0, 0.0, 1.0, 0.0, recorded[3], 0.0}));
  const std::vector<double> without = shares({}, eye);  // one owner fewer in front
  EXPECT_EQ((std::vector<double>(without.begin() + 3, without.end())),
            (std::vector<double>{0.0, 1.0, 0.0, 1.0, 0.0, recorded[3]}));
  // LiDARs have no visibility sets and use all particles.
  const std::vector<double> of_lidar = shares(scene.actors, std::nullopt);
  EXPECT_EQ((std::vector<double>(of_lidar.begin() + 4, of_lidar.end())),
            (std::vector<double>{1.0, 0.0, 1.0, 0.0, 1.0, 0.0}));

  // Inpainted particles of an actor of a visibility set are used where that visibility set is nearest.
  scene.camera = GaussianSet(SetKind::kCamera, 0, 4);
  scene.camera.rotation().col(0).setOnes();
  scene.camera.mean().col(0) << 50.0F, 150.0F, 60.0F, 160.0F;
  scene.camera.actor = {inpainted_number(scene, 0),
                        inpainted_number(scene, 1),
                        inpainted_number(scene, 1),
                        disoccluded_number(scene, 1)};
  EXPECT_EQ(background_of(scene, SetKind::kCamera).mean().col(0).sum(), 200.0F);
  EXPECT_EQ(moment_of(scene, SetKind::kCamera, 1.0).mean().col(0).sum(), 160.0F);
}

// From above all sets have similar distances: several are used, the nearest completely.
TEST(VisibilitySets, AreSeenTogetherFromAfar) {
  const std::vector<double> shares = visibility_shares(three_chunks(), {150.0, 0.0, 100.0});
  EXPECT_NEAR(shares[0], 1.0 - (std::hypot(50.0, 100.0) - 100.0) / 100.0, 1e-9);
  EXPECT_EQ(shares[1], 1.0);
  EXPECT_EQ(shares[2], shares[0]);
}

}  // namespace
}  // namespace simuli
