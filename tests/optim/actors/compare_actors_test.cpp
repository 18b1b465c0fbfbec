#include "optim/actors/compare_actors.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace simuli {
namespace {

using Eigen::Vector3d;

Actor driving(const std::string& name, double y, double speed, double turned = 0.0, double wobble_m = 0.0) {
  Actor out;
  out.name = name;
  out.size_m = {4.0, 1.8, 1.5};
  for (int k = 0; k < 20; ++k) {
    const Eigen::Quaterniond rotation(Eigen::AngleAxisd(turned, Vector3d::UnitZ()));
    const double off_m = k % 2 == 0 ? wobble_m : -wobble_m;
    out.track.push_back({0.1 * k, {rotation, {0.1 * k * speed + off_m, y, 0.75}}});
  }
  return out;
}

TEST(CompareActors, TakesTheCommonOffsetOff) {
  Actor label = driving("car_0", 3.0, 8.0);
  Actor found = driving("moving_0", 3.2, 8.0, 0.03, 0.04);
  found.size_m.x() = 3.5;
  const ActorComparison c = compare_actors({label, driving("standing", 9.0, 0.0)}, {found}, 2.0);
  ASSERT_EQ(c.labels.size(), 1U);  // static labels are ignored
  const ActorMatch& m = c.labels[0];
  EXPECT_EQ(m.found, "moving_0");
  EXPECT_EQ(m.times, 20U);
  EXPECT_NEAR(m.offset_m.y(), 0.2, 1e-9);
  EXPECT_NEAR(std::abs(m.offset_m.x()), 0.04, 1e-9);
  EXPECT_LE(m.centre_m, 0.08 + 1e-9);
  EXPECT_NEAR(m.centre_p90_m, 0.08, 1e-9);
  EXPECT_NEAR(m.turned_rad, 0.03, 1e-9);
  EXPECT_NEAR(m.heading_rad, 0.0, 1e-9);
  EXPECT_EQ(m.found_size_m.x(), 3.5);
  EXPECT_TRUE(c.others.empty());
}

TEST(CompareActors, SaysWhatIsMissedAndWhatHasNoLabel) {
  const ActorComparison c =
      compare_actors({driving("car_0", 3.0, 8.0)}, {driving("moving_0", -6.0, 8.0)}, 2.0);
  ASSERT_EQ(c.labels.size(), 1U);
  EXPECT_TRUE(c.labels[0].found.empty());
  EXPECT_EQ(c.others, std::vector<std::string>{"moving_0"});
}

}  // namespace
}  // namespace simuli
