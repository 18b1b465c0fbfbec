#include "optim/data/refined_path.hpp"

#include <gtest/gtest.h>

#include "host/core/base/angles.hpp"
#include "tests/io/scratch.hpp"
#include "tests/optim/calibration/street_drive.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace {

class RefinedPath : public testing::Test {
 protected:
  RefinedPath() {
    StreetOptions options;
    options.output = scratch_ / "street.log";
    options.frames = 9;
    options.image_width = 32;
    options.image_height = 18;
    log_ = synth_street(options);
  }
  /// Returns the log with small errors in all poses.
  [[nodiscard]] Log shaken(double position_m, double rotation_rad) const {
    test::Random random(7);
    std::vector<TimedPose> poses = log_.world_from_rig.poses();
    for (TimedPose& pose : poses) {
      const Eigen::Vector3d shift(random.normal(), random.normal(), random.normal());
      const Eigen::Vector3d turn(random.normal(), random.normal(), random.normal());
      pose.pose.translation += position_m * shift;
      const double angle = rotation_rad * turn.norm();
      pose.pose.rotation =
          pose.pose.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn.normalized()));
    }
    Log log = log_;
    log.world_from_rig = Trajectory(poses);
    return log;
  }
  /// Returns the RMS error of motions between sweeps; a common error of the trajectory is not observable.
  [[nodiscard]] double step_error_m(const Log& log) const {
    double sum = 0.0;
    for (std::size_t i = 1; i < log.sweeps.size(); ++i) {
      const auto step = [&log, i](const Trajectory& path) {
        return path.at(log.sweeps[i - 1].time_start_s).inverse() * path.at(log.sweeps[i].time_start_s);
      };
      sum += (step(log.world_from_rig).translation - step(log_.world_from_rig).translation).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(log.sweeps.size() - 1));
  }
  test::Scratch scratch_;
  Log log_;
};

TEST_F(RefinedPath, TakesBackWhatPosesAreOff) {
  const Log log = shaken(0.03, 0.1 * kDegree);
  const auto [refined, report] = with_refined_path(log);
  ASSERT_TRUE(report.used) << report.reason;
  EXPECT_EQ(report.sweeps, 9U);
  EXPECT_LT(report.refined_m, 0.5 * report.recorded_m);
  EXPECT_GT(step_error_m(log), 0.02);
  EXPECT_LT(step_error_m(refined), 0.2 * step_error_m(log));
  EXPECT_GT(report.largest_change_m, 0.01);
  EXPECT_LT(report.largest_change_m, 0.3);
  // Boxes remain at the rig-relative pose of their measurement.
  ASSERT_FALSE(refined.actors.empty());
  const KeyPose &before = log.actors[0].track[3], &after = refined.actors[0].track[3];
  const Pose was = log.world_from_rig.at(before.time_s).inverse() * before.world_from_actor;
  const Pose is = refined.world_from_rig.at(after.time_s).inverse() * after.world_from_actor;
  EXPECT_LT((was.translation - is.translation).norm(), 1e-9);
}

TEST_F(RefinedPath, LeavesWhatNoSweepDoubts) {
  const auto [log, report] = with_refined_path(log_);
  EXPECT_FALSE(report.used);
  EXPECT_FALSE(report.reason.empty());
  ASSERT_EQ(log.world_from_rig.poses().size(), log_.world_from_rig.poses().size());
  for (std::size_t i = 0; i < log.world_from_rig.poses().size(); ++i) {
    EXPECT_EQ(log.world_from_rig.poses()[i].pose.translation,
              log_.world_from_rig.poses()[i].pose.translation);
  }
}

TEST_F(RefinedPath, IsNotLookedForWithFewSweeps) {
  Log few = log_;
  few.sweeps.resize(4);
  const PathReport report = with_refined_path(few).report;
  EXPECT_FALSE(report.used);
  EXPECT_EQ(report.reason, "4 sweeps of a LiDAR, 8 are needed");
}

}  // namespace
}  // namespace simuli
