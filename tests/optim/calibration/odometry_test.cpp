// Tests trajectories estimated in the analytic street with ground truth and in recorded sweeps.
#include "optim/calibration/path/odometry.hpp"

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <stdexcept>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "optim/calibration/path/refine.hpp"
#include "optim/calibration/path/spin.hpp"
#include "tests/optim/calibration/street_drive.hpp"

namespace simuli::calibration {
namespace {

struct PathError {
  double step_m = 0.0;  // maximum over the segments
  double step_rad = 0.0;
  double end_m = 0.0;  // from the first knot to the last
  double end_rad = 0.0;
};

PathError error_of(const std::vector<TimedPose>& path, const Trajectory& truth) {
  const auto apart = [&](std::size_t a, std::size_t b) {
    const Pose found = path[a].pose.inverse() * path[b].pose;
    const Pose real = truth.at(path[a].time_s).inverse() * truth.at(path[b].time_s);
    return real.inverse() * found;
  };
  PathError error;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Pose off = apart(i - 1, i);
    error.step_m = std::max(error.step_m, off.translation.norm());
    error.step_rad = std::max(error.step_rad, off.rotation.angularDistance(Eigen::Quaterniond::Identity()));
  }
  const Pose off = apart(0, path.size() - 1);
  error.end_m = off.translation.norm();
  error.end_rad = off.rotation.angularDistance(Eigen::Quaterniond::Identity());
  return error;
}

class StreetPath : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    drive_ = new test::StreetDrive(12, 8.0, 0.3);
    sweeps_ = new std::vector<Returns>(drive_->returns());
  }
  static void TearDownTestSuite() {
    delete sweeps_;
    delete drive_;
  }
  inline static test::StreetDrive* drive_ = nullptr;
  inline static std::vector<Returns>* sweeps_ = nullptr;
};

TEST_F(StreetPath, IsFoundWithoutAnyPose) {
  std::vector<TimedPose> path = find_path(*sweeps_, {});
  ASSERT_EQ(path.size(), sweeps_->size() + 1);
  const PathError odometry = error_of(path, drive_->log.world_from_rig);
  // Sweep by sweep, over 10 m without an initial value.
  EXPECT_LT(odometry.end_m, 0.03);
  const RefineReport report = refine_path(*sweeps_, {}, {}, path);
  const PathError refined = error_of(path, drive_->log.world_from_rig);
  EXPECT_LT(refined.step_m, 0.008);
  EXPECT_LT(refined.step_rad, 0.05 * kDegree);
  EXPECT_LT(refined.end_m, 0.02);
  EXPECT_LT(refined.end_rad, 0.05 * kDegree);
  // The end position has an error of about 1 cm in both; refinement must improve the steps.
  EXPECT_LT(refined.step_m, odometry.step_m);
  EXPECT_LT(refined.step_rad, odometry.step_rad);
  EXPECT_GT(report.planes, 300U);
  EXPECT_GT(report.step_sigma_m, 0.0);
  EXPECT_LT(report.step_sigma_m, 0.01);
  EXPECT_LT(fit_of(*sweeps_, path).median_m, 0.015);
  // Equal sweeps give equal bits.
  std::vector<TimedPose> again = find_path(*sweeps_, {});
  (void)refine_path(*sweeps_, {}, {}, again);
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(path[i].pose.translation, again[i].pose.translation) << i;
    EXPECT_EQ(path[i].pose.rotation.coeffs(), again[i].pose.rotation.coeffs()) << i;
  }
}

TEST_F(StreetPath, FollowsAPriorAsFarAsItIsBelieved) {
  // A prior with a constant error of 0.5 m and 1 degree: only the prior defines the world frame.
  const Pose world_from_truth{Eigen::Quaterniond(Eigen::AngleAxisd(kDegree, Eigen::Vector3d::UnitZ())),
                              {0.0, 0.5, 0.0}};
  std::vector<TimedPose> poses;
  for (const TimedPose& p : drive_->log.world_from_rig.poses())
    poses.push_back({p.time_s, world_from_truth * p.pose});
  const PathPrior prior{Trajectory(poses), 0.02, 0.1 * kDegree};
  std::vector<TimedPose> path;
  for (const double t : knot_times(*sweeps_)) path.push_back({t, drive_->log.world_from_rig.at(t)});
  (void)refine_path(*sweeps_, prior, {}, path);
  for (const TimedPose& knot : path) {
    EXPECT_LT((knot.pose.translation - prior.world_from_rig.at(knot.time_s).translation).norm(), 0.05);
  }
  EXPECT_LT(error_of(path, drive_->log.world_from_rig).step_m, 0.008);
}

TEST_F(StreetPath, RefinementHearsWhoInterrupts) {
  std::vector<TimedPose> start;
  for (const double t : knot_times(*sweeps_)) start.push_back({t, drive_->log.world_from_rig.at(t)});
  const auto refine = [&](const std::function<void()>& look) {
    const Interruption interruption(look);
    std::vector<TimedPose> path = start;
    (void)refine_path(*sweeps_, {}, {}, path);
  };
  int looks = 0;
  const std::clock_t begin = std::clock();
  std::clock_t last = begin, longest = 0;
  refine([&] {
    ++looks;
    const std::clock_t now = std::clock();
    longest = std::max(longest, now - std::exchange(last, now));
  });
  EXPECT_LT(longest, (std::clock() - begin) / 8);  // CPU time
  // Threads take pieces dynamically: the calling thread's share varies.
  for (const int last_look : {1, looks / 3, looks / 2, looks - looks / 1000}) {
    int left = last_look;
    EXPECT_THROW(refine([&] {
                   if (--left == 0) throw std::runtime_error("enough");
                 }),
                 std::runtime_error)
        << last_look << " of " << looks;
  }
  const std::function<void()> enough = [] { throw std::runtime_error("enough"); };
  const Interruption interruption(enough);
  EXPECT_THROW((void)fit_of(*sweeps_, start), std::runtime_error);
}

TEST_F(StreetPath, TheSpinIsTheOneThatKeepsWallsFlat) {
  const std::vector<Returns> head(sweeps_->begin(), sweeps_->begin() + 6);
  std::vector<Returns> reversed = drive_->returns(true);
  reversed.resize(6);
  const SpinReport right = find_spin(head, reversed);
  ASSERT_TRUE(right.spin) << right.reason;
  EXPECT_EQ(*right.spin, SpinDirection::kClockwise);  // the spin of the street's sensor
  const SpinReport swapped = find_spin(reversed, head);
  ASSERT_TRUE(swapped.spin);
  EXPECT_EQ(*swapped.spin, SpinDirection::kCounterClockwise);
}

TEST(Spin, IsNotToldByARestingRig) {
  const test::StreetDrive drive(3, 0.0, 0.0);
  std::vector<Returns> forward = drive.returns();
  std::vector<Returns> reversed = drive.returns(true);
  const SpinReport report = find_spin(forward, reversed);
  EXPECT_FALSE(report.spin);
  EXPECT_NE(report.reason.find("hardly moves"), std::string::npos) << report.reason;
}

/// Returns sweeps of a rig that moves 0.8 m per sweep along x between walls; `wall(direction)` is the
/// distance along a ray.
template <class Wall>
std::vector<Returns> made_up_sweeps(const Wall& range) {
  std::mt19937_64 dice(5);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::vector<Returns> sweeps;
  for (int s = 0; s < 4; ++s) {
    Returns& sweep = sweeps.emplace_back();
    sweep.time_start_s = 0.1 * s;
    sweep.time_end_s = 0.1 * (s + 1);
    for (int r = 0; r < 24; ++r) {
      for (int c = 0; c < 720; ++c) {
        const Eigen::Vector3d d = Lidar::direction(c * 0.5 * kDegree, (10.0 - r) * kDegree);
        const double distance = range(d);
        if (!(distance > 2.0 && distance < 60.0)) continue;
        sweep.p_rig.push_back((distance + noise(dice)) * d);
        sweep.time_s.push_back(sweep.time_start_s + 0.1 * c / 720.0);
      }
    }
  }
  return sweeps;
}

void expect_refusal(const std::vector<Returns>& sweeps, const std::string& part) {
  try {
    (void)find_path(sweeps, {});
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNumeric);
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(Odometry, RefusesATunnel) {
  // Two walls and a floor along x: the position along x is not determined.
  expect_refusal(made_up_sweeps([](const Eigen::Vector3d& d) {
                   const double side = 4.0 / std::max(1e-9, std::abs(d.y()));
                   const double floor = d.z() < 0.0 ? 1.8 / -d.z() : 1e9;
                   return std::min(side, floor);
                 }),
                 "do not determine the motion along (1.00, ");
}

TEST(Odometry, RefusesABlankWall) {
  expect_refusal(made_up_sweeps([](const Eigen::Vector3d& d) { return d.y() > 0.0 ? 6.0 / d.y() : 1e9; }),
                 "do not determine the motion along");
}

TEST(Odometry, RefusesARoundTower) {
  // All normals point to the rig: the rotation is not determined.
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> normals;
  for (int i = 0; i < 360; ++i) {
    for (int k = -3; k <= 3; ++k) {
      const Eigen::Vector3d out(std::cos(i * kDegree), std::sin(i * kDegree), 0.0);
      points.push_back(10.0 * out + 2.0 * k * Eigen::Vector3d::UnitZ());
      normals.push_back(out);
      points.push_back(Eigen::Vector3d(0.0, 0.0, -2.0) + (3.0 + k) * out);
      normals.push_back(Eigen::Vector3d::UnitZ());
    }
  }
  const Constraint c = constraint_of(points, normals);
  EXPECT_GT(c.least_shift, 0.2);
  EXPECT_LT(c.least_turn, 1e-6);
  EXPECT_NEAR(std::abs(c.turn_axis.z()), 1.0, 1e-6);
}

TEST(Odometry, KnotsFollowTheSweeps) {
  const auto sweep = [](double start_s, double end_s) {
    Returns out;
    out.time_start_s = start_s;
    out.time_end_s = end_s;
    return out;
  };
  EXPECT_EQ(knot_times({sweep(0.0, 0.1), sweep(0.1, 0.2)}), (std::vector<double>{0.0, 0.1, 0.2}));
  EXPECT_EQ(knot_times({sweep(0.0, 0.1), sweep(0.3, 0.4)}), (std::vector<double>{0.0, 0.1, 0.3, 0.4}));
  EXPECT_THROW((void)knot_times({sweep(0.0, 0.1), sweep(0.0, 0.1)}), Error);
}

TEST(Odometry, Kitti) {
  const char* const data = std::getenv("SIMULI_DATA");
  if (data == nullptr) GTEST_SKIP() << "not run: sweeps of KITTI's drive 0013, SIMULI_DATA is not set";
  const std::filesystem::path root = std::filesystem::path(data) / "kitti";
  constexpr std::size_t kSweeps = 8;
  std::vector<Returns> sweeps;
  std::vector<Pose> truth;
  std::vector<double> forward_s;
  read_json_text(read_file(root / "poses_0013.json"), "poses_0013.json", [&](JsonObject& json) {
    json.ignore_other_keys();
    return json.objects("frames", [&](JsonObject& frame) {
      frame.ignore_other_keys();
      if (sweeps.size() == kSweeps) return 0;
      Returns& sweep = sweeps.emplace_back();
      sweep.time_start_s = frame.number("t_sweep_start") - 47451.0;
      sweep.time_end_s = frame.number("t_sweep_end") - 47451.0;
      forward_s.push_back(frame.number("t_sweep_forward") - 47451.0);
      Eigen::Matrix<double, 3, 4> m;
      const Json& rows = frame.get("world_from_velo");
      for (int i = 0; i < 12; ++i) {
        m(i / 4, i % 4) =
            rows[static_cast<std::size_t>(i / 4)][static_cast<std::size_t>(i % 4)].get<double>();
      }
      truth.push_back(Pose::from_matrix(m));
      const auto index = static_cast<int>(frame.integer("index"));
      const std::string file =
          fmt::format("2011_09_26/2011_09_26_drive_0013_sync/velodyne_points/data/{:010}.bin", index);
      for (const kitti::Point& point : kitti::read_points(root / file)) {
        const Eigen::Vector3d& p = point.position;
        if (!(p.norm() >= 2.0)) continue;
        const double share = 0.5 - std::atan2(p.y(), p.x()) / (2.0 * std::numbers::pi);
        sweep.p_rig.push_back(p);
        sweep.time_s.push_back(sweep.time_start_s + share * (sweep.time_end_s - sweep.time_start_s));
      }
      return 0;
    });
  });
  ASSERT_EQ(sweeps.size(), kSweeps);
  std::vector<TimedPose> path = find_path(sweeps, {});
  (void)refine_path(sweeps, {}, {}, path);
  EXPECT_LT(fit_of(sweeps, path).median_m, 0.015);
  const Trajectory found(path);
  double metres = 0.0;
  for (std::size_t i = 1; i < kSweeps; ++i)
    metres += (truth[i].translation - truth[i - 1].translation).norm();
  const Pose real = truth.front().inverse() * truth.back();
  const Pose ours = found.at(forward_s.front()).inverse() * found.at(forward_s.back());
  const Pose off = real.inverse() * ours;
  EXPECT_LT(off.translation.norm() / metres, 0.01);
  EXPECT_LT(off.rotation.angularDistance(Eigen::Quaterniond::Identity()) / metres, 0.05 * kDegree);
}

}  // namespace
}  // namespace simuli::calibration
