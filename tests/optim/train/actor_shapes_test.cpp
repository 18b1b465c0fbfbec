// Tests shapes of non-rigid actors: their selection and training.
#include "optim/actors/actor_shapes.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace simuli {
namespace {

Actor one(const std::string& kind, const Eigen::Vector3d& size_m) {
  Actor actor;
  actor.name = kind;
  actor.kind = kind;
  actor.size_m = size_m;
  for (int k = 0; k < 11; ++k) {
    KeyPose key;
    key.time_s = 2.0 + 0.1 * k;
    actor.track.push_back(key);
  }
  return actor;
}

TEST(ActorShapes, AreThoseOfPeopleAndRiders) {
  const Eigen::Vector3d person(0.8, 0.6, 1.7), car(4.1, 1.8, 1.5);
  for (const char* const kind :
       {"pedestrian", "human.pedestrian.adult", "Cyclist", "PERSON_SITTING", "vehicle.bicycle"})
    EXPECT_TRUE(is_non_rigid(one(kind, person))) << kind;
  for (const char* const kind : {"car", "van", "truck", "sign", "vehicle.bus.rigid"})
    EXPECT_FALSE(is_non_rigid(one(kind, person))) << kind;
  // For found actors only the size is known.
  EXPECT_TRUE(is_non_rigid(one("moving", person)));
  EXPECT_TRUE(is_non_rigid(one("moving", {0.6, 1.9, 1.8})));
  EXPECT_FALSE(is_non_rigid(one("moving", car)));
  EXPECT_FALSE(is_non_rigid(one("moving", {0.8, 0.6, 0.3})));
}

TEST(ActorShapes, LastAsLongAsTheirTracks) {
  const Eigen::Vector3d size(0.8, 0.6, 1.7);
  std::vector<Actor> actors{one("car", size), one("pedestrian", size)};
  prepare_shapes(actors);
  EXPECT_TRUE(actors[0].deformation.empty());
  const Deformation& shape = actors[1].deformation;
  ASSERT_FALSE(shape.empty());
  EXPECT_LE(shape.start_s, 2.0 - Actor::kReach_s);
  EXPECT_GE(shape.start_s + shape.interval_s * static_cast<double>(shape.knots() - 1),
            3.0 + Actor::kReach_s - 1e-9);
  validate(actors[1], "prepared");
}

/// Trains on nodes that move ahead by 0.2 m and back, with frames every 0.1 s except every third.
TEST(ActorShapes, FollowGradientsAndGoOnBetweenFrames) {
  std::vector<Actor> actors{one("pedestrian", {0.8, 0.6, 1.7})};
  prepare_shapes(actors);
  const auto truth = [](double time_s) { return 0.2 * std::sin(2.0 * M_PI * 0.9 * time_s); };
  ActorShapes shapes(true);
  constexpr int kSteps = 2000;
  const std::size_t row = 3 * actors[0].deformation.node_count();
  const auto off = [&](double time_s) { return actors[0].deformation.at(time_s)[0] - truth(time_s); };
  for (int i = 0; i < kSteps; ++i) {
    const int frame = i * 7 % 11;
    if (frame % 3 == 2) continue;
    const double time_s = 2.0 + 0.1 * frame;
    DeformationGradient gradient{std::vector<double>(row, 0.0), std::vector<double>(row, 0.0)};
    for (std::size_t j = 0; j < row; j += 3)
      gradient.start[j] = actors[0].deformation.at(time_s)[j] - truth(time_s);
    shapes.step(actors, {gradient}, time_s, time_s + 0.05, static_cast<double>(i) / kSteps);
  }
  double seen = 0.0, unseen = 0.0;
  for (int frame = 0; frame < 11; ++frame) {
    double& worst = frame % 3 == 2 ? unseen : seen;
    worst = std::max(worst, std::abs(off(2.0 + 0.1 * frame)));
  }
  EXPECT_LT(seen, 0.03);
  EXPECT_LT(unseen, 0.06);
  // Parameters without gradients are unchanged.
  EXPECT_EQ(actors[0].deformation.at(2.55)[1], 0.0);
}

TEST(ActorShapes, GoOnFromACheckpoint) {
  const Eigen::Vector3d size(0.8, 0.6, 1.7);
  std::vector<Actor> actors{one("pedestrian", size), one("car", size), one("cyclist", size)};
  prepare_shapes(actors);
  const std::size_t row = 3 * actors[0].deformation.node_count();
  const auto gradients = [&](int i) {
    DeformationGradient g{std::vector<double>(row), std::vector<double>(row)};
    for (std::size_t j = 0; j < row; ++j) g.start[j] = std::sin(i + 0.1 * static_cast<double>(j));
    return std::vector<DeformationGradient>{g, {}, g};
  };
  ActorShapes first(true);
  for (int i = 0; i < 5; ++i) first.step(actors, gradients(i), 2.1, 2.2, 0.1);
  std::vector<Actor> again = actors;
  ActorShapes second(true);
  second.set_numbers(again, first.numbers(actors));
  first.step(actors, gradients(7), 2.3, 2.4, 0.2);
  second.step(again, gradients(7), 2.3, 2.4, 0.2);
  for (const std::size_t actor : {0U, 2U})
    EXPECT_EQ(actors[actor].deformation.offsets_m, again[actor].deformation.offsets_m);
  // NaN gradients have no effect.
  auto bad = gradients(1);
  bad[0].start[5] = std::nan("");
  const std::vector<double> before = actors[0].deformation.offsets_m;
  first.step(actors, {bad[0]}, 2.3, 2.4, 0.2);
  EXPECT_EQ(actors[0].deformation.offsets_m, before);
}

}  // namespace
}  // namespace simuli
