#include "host/scene/owners/vistas.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "host/scene/owners/moment.hpp"
#include "host/scene/owners/occluders.hpp"

namespace simuli {
namespace {

/// Three stretches of 100 m along x, as places 5 m apart tell them.
std::vector<Vista> three_stretches() {
  std::vector<Vista> vistas(3);
  for (std::size_t k = 0; k < 3; ++k) {
    for (int i = 0; i <= 20; ++i) {
      vistas[k].path_m.emplace_back(100.0 * static_cast<double>(k) + 5.0 * i, 0.0, 0.0);
    }
  }
  return vistas;
}

TEST(Vistas, AreSeenFromTheirStretchAndFadeBehindIt) {
  const std::vector<Vista> vistas = three_stretches();
  const auto shares = [&](double x, double y) { return vista_shares(vistas, {x, y, 1.5}); };
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
  expect(105.0, 0.0, 0.63, 1.0, 0.0);  // the eye is 1.5 m above the path
  expect(112.0, 0.0, 0.0, 1.0, 0.0);
  expect(150.0, 40.0, 0.0, 1.0, 0.0);
  expect(400.0, 0.0, 0.0, 0.0, 1.0);
  std::vector<double> before = shares(-20.0, 2.0);
  for (double x = -20.0; x <= 330.0; x += 0.25) {
    const std::vector<double> now = shares(x, 2.0);
    EXPECT_EQ(*std::max_element(now.begin(), now.end()), 1.0) << x;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(now[k], before[k], 0.026) << x;
    before = now;
  }
  EXPECT_TRUE(vista_shares({}, {0.0, 0.0, 0.0}).empty());
  const Vista place{{{3.0, 0.0, 0.0}}};
  EXPECT_EQ(vista_shares({place}, {900.0, 0.0, 0.0}), std::vector<double>{1.0});
}

TEST(Vistas, AreOwnersBetweenActorsAndOccluders) {
  Scene scene;
  scene.origin = {1000.0, 0.0, 0.0};
  scene.vistas = three_stretches();
  for (Vista& vista : scene.vistas) {
    for (Eigen::Vector3d& place : vista.path_m) place += scene.origin;
  }
  Actor car{"car", "car", {4.0, 2.0, 1.5}, {}};
  for (const double time_s : {0.0, 2.0}) car.track.push_back({time_s, {}});
  scene.actors = {car};
  scene.occluders = {car};
  ASSERT_EQ(most_numbers(scene), 6U);
  EXPECT_EQ(number_of_vista(scene, 0), 2U);
  EXPECT_EQ(number_of_vista(scene, 2), 4U);
  EXPECT_EQ(number_behind(scene, 0), 5U);
  const auto there = [&](const std::optional<Eigen::Vector3d>& eye) {
    std::vector<bool> out;
    for (const ActorView& view : owners_during(scene, scene.actors, 1.0, 1.0, eye))
      out.push_back(view.is_there);
    return out;
  };
  EXPECT_EQ(there(Eigen::Vector3d(1250.0, 0.0, 0.0)),
            (std::vector<bool>{true, false, false, true, true, false}));
  EXPECT_EQ(there(Eigen::Vector3d(1104.0, 0.0, 0.0)),
            (std::vector<bool>{true, true, true, false, true, false}));
  EXPECT_EQ(there(std::nullopt), (std::vector<bool>{true, true, true, true, true, false}));
  const auto views = owners_during(scene, scene.actors, 1.0, 1.0, Eigen::Vector3d(1104.0, 0.0, 0.0));
  EXPECT_NEAR(views[1].share, 0.6, 1e-9);
  EXPECT_EQ(views[2].share, 1.0);

  // Programs that know nothing of all this get every one of them.
  scene.camera = GaussianSet(SetKind::kCamera, 0, 6);
  scene.camera.rotation().col(0).setOnes();
  for (Eigen::Index i = 0; i < 6; ++i) scene.camera.mean()(i, 0) = static_cast<float>(i);
  scene.camera.actor = {0, 1, 2, 3, 4, number_behind(scene, 0)};
  EXPECT_EQ(background_of(scene, SetKind::kCamera).size(), 4);
  EXPECT_EQ(moment_of(scene, SetKind::kCamera, 1.0).size(), 6);
}

}  // namespace
}  // namespace simuli
