#include "optim/actors/complete_actors.hpp"

#include <gtest/gtest.h>

namespace simuli {
namespace complete_actors_test {

using Eigen::Vector3d;

/// Returns keys `first` to `last` at 10 Hz, along x at 8 m/s.
Actor driving(const std::string& name,
              int first,
              int last,
              const Vector3d& off_m = Vector3d::Zero(),
              double turned = 0.0) {
  Actor out;
  out.name = name;
  out.size_m = {4.0, 1.8, 1.5};
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(turned, Vector3d::UnitZ()));
  for (int k = first; k <= last; ++k)
    out.track.push_back({0.1 * k, {rotation, Vector3d(0.8 * k, 3.0, 0.75) + off_m}});
  return out;
}

const Vector3d kOff_m(-0.3, 0.1, -0.05);

TEST(CompleteActors, ALabelGoesOnBeforeAndAfterWithoutTheOffset) {
  const CompletedActors c =
      complete_actors({driving("car_0", 5, 12)}, {{driving("moving_0", 0, 20, kOff_m, 0.02)}, {}, {}});
  ASSERT_EQ(c.actors.size(), 1U);
  EXPECT_EQ(c.added, 0U);
  EXPECT_EQ(c.continued, 1U);
  EXPECT_EQ(c.actors[0].name, "car_0");
  const Actor whole = driving("car_0", 0, 20);
  ASSERT_EQ(c.actors[0].track.size(), whole.track.size());
  for (std::size_t k = 0; k < whole.track.size(); ++k) {
    const KeyPose& key = c.actors[0].track[k];
    EXPECT_EQ(key.time_s, whole.track[k].time_s);
    EXPECT_LT((key.world_from_actor.translation - whole.track[k].world_from_actor.translation).norm(), 1e-9)
        << k;
    EXPECT_LT(key.world_from_actor.rotation.angularDistance(whole.track[k].world_from_actor.rotation), 1e-9);
    if (k >= 5 && k <= 12) {
      EXPECT_EQ(key.world_from_actor.translation.y(), 3.0);
    }  // bits of the label
  }
}

TEST(CompleteActors, WhatHasNoLabelIsAddedUnderAFreeName) {
  const Vector3d beside(0.0, -6.0, 0.0);
  const CompletedActors c =
      complete_actors({driving("moving_0", 0, 20)},
                      {{driving("moving_0", 0, 20, beside), driving("moving_1", 0, 20)}, {}, {}});
  ASSERT_EQ(c.actors.size(), 2U);
  EXPECT_EQ(c.added, 1U);
  EXPECT_EQ(c.continued, 0U);
  EXPECT_EQ(c.actors[0].track.size(), 21U);
  EXPECT_EQ(c.actors[1].name, "moving_1");
  EXPECT_EQ(c.actors[1].track[0].world_from_actor.translation.y(), -3.0);
}

TEST(CompleteActors, WithoutLabelsItIsWhatWasFound) {
  const CompletedActors c =
      complete_actors({}, {{driving("moving_0", 0, 9), driving("moving_1", 0, 9, {0, 9, 0})}, {}, {}});
  ASSERT_EQ(c.actors.size(), 2U);
  EXPECT_EQ(c.added, 2U);
  EXPECT_EQ(c.actors[1].name, "moving_1");
}

TEST(CompleteActors, OfTwoLabelsOfOneTheNextInTimeGoesOn) {
  const CompletedActors c = complete_actors({driving("car_0", 0, 6), driving("car_1", 14, 20)},
                                            {{driving("moving_0", 0, 24, kOff_m)}, {}, {}});
  ASSERT_EQ(c.actors.size(), 2U);
  EXPECT_EQ(c.continued, 2U);
  EXPECT_EQ(c.actors[0].track.size() + c.actors[1].track.size(), 25U);
  EXPECT_NEAR(c.actors[0].track.back().time_s, 1.0, 0.11);  // halfway to the second one's first
  EXPECT_EQ(c.actors[1].track.back().time_s, 0.1 * 24);
  for (std::size_t k = 0; k < c.actors[1].track.size(); ++k)
    EXPECT_NEAR(c.actors[1].track[k].world_from_actor.translation.y(), 3.0, 1e-9);
}

TEST(CompleteActors, LabelsThatNothingWasFoundOfStayButThoseThatStand) {
  const CompletedActors c =
      complete_actors({driving("wall", 0, 6), driving("car_0", 0, 6)}, {{}, {"wall"}, {}});
  ASSERT_EQ(c.actors.size(), 1U);
  EXPECT_EQ(c.actors[0].name, "car_0");
  EXPECT_EQ(c.actors[0].track.size(), 7U);
}

}  // namespace complete_actors_test
}  // namespace simuli
