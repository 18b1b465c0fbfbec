#include "host/core/sensors/trajectory.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "tests/host/expect_error.hpp"

namespace simuli {
namespace trajectory_test {

constexpr double kRounding = 1e-12;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TimedPose at_x(double time_s, double x_m) { return {time_s, {Eigen::Quaterniond::Identity(), {x_m, 0, 0}}}; }

/// Returns a trajectory that rests for 1 s, then moves 1 m/s for 2 s.
Trajectory stop_and_go() { return Trajectory({at_x(1, 0), at_x(2, 0), at_x(4, 2)}); }

TEST(Trajectory, InterpolatesWithinTheRightSegment) {
  const Trajectory t = stop_and_go();
  EXPECT_NEAR(t.at(1.5).translation.x(), 0.0, kRounding);
  EXPECT_NEAR(t.at(2.0).translation.x(), 0.0, kRounding);
  EXPECT_NEAR(t.at(3.0).translation.x(), 1.0, kRounding);
  EXPECT_NEAR(t.at(4.0).translation.x(), 2.0, kRounding);
  EXPECT_EQ(t.start_s(), 1.0);
  EXPECT_EQ(t.end_s(), 4.0);
}

TEST(Trajectory, ContinuesAtConstantVelocityPastEitherEnd) {
  const Trajectory t = stop_and_go();
  EXPECT_NEAR(t.at(4.0 + Trajectory::kExtrapolation_s).translation.x(), 2.25, kRounding);
  EXPECT_NEAR(t.at(1.0 - Trajectory::kExtrapolation_s).translation.x(), 0.0, kRounding);
}

TEST(Trajectory, ContinuesATurn) {
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  const Trajectory t({{0.0, {}}, {1.0, {turned, Eigen::Vector3d::Zero()}}});
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(0.48, Eigen::Vector3d::UnitZ()));
  EXPECT_LT(t.at(1.2).rotation.angularDistance(expected), 1e-7);  // acos near 1 loses half the digits
}

TEST(Trajectory, RefusesTimesFurtherOut) {
  const Trajectory t = stop_and_go();
  expect_error(ErrorKind::kInput, "found 4.251 s", [&] { (void)t.at(4.251); });
  expect_error(ErrorKind::kInput, "allowed 1 to 4 s", [&] { (void)t.at(0.749); });
  expect_error(ErrorKind::kInput, "time", [&] { (void)t.at(kNan); });
}

TEST(Trajectory, OnePoseStandsStill) {
  const Trajectory t({at_x(5, 3)});
  EXPECT_EQ(t.at(5.2).translation.x(), 3.0);
  expect_error(ErrorKind::kInput, "time", [&] { (void)t.at(5.3); });
}

TEST(Trajectory, RefusesWhatIsNoTrajectory) {
  expect_error(ErrorKind::kInput, "at least 1", [] { Trajectory(std::vector<TimedPose>{}); });
  expect_error(ErrorKind::kInput, "poses[1].time", [] { Trajectory({at_x(1, 0), at_x(1, 0)}); });
  expect_error(ErrorKind::kInput, "poses[2].time", [] { Trajectory({at_x(1, 0), at_x(3, 0), at_x(2, 0)}); });
  expect_error(ErrorKind::kInput, "poses[0]", [] { Trajectory({at_x(1, kNan)}); });
  expect_error(ErrorKind::kInput, "poses[1]", [] { Trajectory({at_x(1, 0), at_x(kNan, 0)}); });
  expect_error(ErrorKind::kInput, "poses[1]: found a place at", [] {
    Trajectory({at_x(1, 0), at_x(2, -1e9)});
  });
}

TEST(Trajectory, RefusesAZeroQuaternion) {
  Pose pose;
  pose.rotation.coeffs().setZero();
  expect_error(ErrorKind::kInput, "poses[0].rotation", [&] { Trajectory({{0.0, pose}}); });
}

TEST(Trajectory, NormalisesRotations) {
  TimedPose p = at_x(0, 0);
  p.pose.rotation.coeffs() *= 2.0;
  EXPECT_NEAR(Trajectory({p}).at(0).rotation.norm(), 1.0, kRounding);
}

}  // namespace trajectory_test
}  // namespace simuli
