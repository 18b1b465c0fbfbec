#include "optim/data/refined_path.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/stopwatch.hpp"
#include "host/core/sensors/sensor.hpp"
#include "optim/calibration/path/align.hpp"

namespace simuli {
namespace {

constexpr double kCloser = 0.97;  // required ratio to the recorded median distance
constexpr double kKept = 0.98;  // required ratio to the recorded share of returns on planes
constexpr double kNear = 0.02;  // m: residual of good registrations, with returns of centimetre noise
constexpr double kFine = 0.001;  // m: nothing left to improve
constexpr std::size_t kMinRefinedSweeps = 8;
/// Standard deviations of recorded GNSS/IMU poses, of which KITTI's have errors of 15 cm. They only matter
/// where surfaces give no information.
constexpr double kPosition_m = 0.1, kRotation_rad = 0.2 * std::numbers::pi / 180.0;

/// Returns the LiDAR with the most sweeps (the first of several), and their number.
std::pair<std::string, std::size_t> busiest_lidar(const Log& log) {
  std::pair<std::string, std::size_t> busiest;
  for (const LogLidar& lidar : log.lidars) {
    const std::string name = name_of(lidar.model);
    const auto sweeps = static_cast<std::size_t>(std::count_if(
        log.sweeps.begin(), log.sweeps.end(), [&name](const SweepFrame& s) { return s.lidar == name; }));
    if (sweeps > busiest.second) busiest = {name, sweeps};
  }
  return busiest;
}

/// Moves the recorded trajectory by the corrections at the knots; its motion between and beyond knots is kept.
Trajectory corrected(const Trajectory& recorded, const std::vector<TimedPose>& knots) {
  std::vector<TimedPose> corrections;
  std::map<double, Pose> poses;
  for (const TimedPose& knot : knots) {
    corrections.push_back({knot.time_s, knot.pose * recorded.at(knot.time_s).inverse()});
    poses[knot.time_s] = knot.pose;
  }
  const Trajectory correction(std::move(corrections));
  for (const TimedPose& pose : recorded.poses()) {
    const double time_s = std::clamp(pose.time_s, correction.start_s(), correction.end_s());
    poses.try_emplace(pose.time_s, correction.at(time_s) * pose.pose);
  }
  std::vector<TimedPose> path;
  for (const auto& [time_s, pose] : poses) path.push_back({time_s, pose});
  return Trajectory(std::move(path));
}

double largest_change_m(const Trajectory& from, const Trajectory& to) {
  double largest = 0.0;
  for (const TimedPose& pose : from.poses()) {
    largest = std::max(largest, (to.at(pose.time_s).translation - pose.pose.translation).norm());
  }
  return largest;
}

calibration::AlignOptions align_options(const std::string& lidar) {
  calibration::AlignOptions align;
  align.lidar = lidar;
  align.use_prior = true;
  align.prior_sigma_m = kPosition_m;
  align.prior_sigma_rad = kRotation_rad;
  align.near_m = kNear;
  align.fine_m = kFine;
  align.spin_sweeps = 0;
  return align;
}

}  // namespace

RefinedLog with_refined_path(
    Log log, const std::function<void(const std::string&, std::size_t, std::size_t)>& progress) {
  RefinedLog out{std::move(log), {}};
  const auto [lidar, sweeps] = busiest_lidar(out.log);
  if (sweeps < kMinRefinedSweeps) {
    out.report.reason = fmt::format("{} sweeps of a LiDAR, {} are needed", sweeps, kMinRefinedSweeps);
    return out;
  }
  const Stopwatch watch;
  out.report.sweeps = sweeps;
  try {
    const calibration::AlignReport found = calibration::align_log(
        out.log, align_options(lidar), [&](const char* stage, std::size_t done, std::size_t total) {
          if (progress) progress(std::string("refine path: ") + stage, done, total);
        });
    PathReport& r = out.report;
    r.recorded_m = found.recorded.median_m;
    r.refined_m = found.refined.median_m;
    r.recorded_share = found.recorded.planar_share;
    r.refined_share = found.refined.planar_share;
    r.used = r.refined_m <= kCloser * r.recorded_m && r.refined_share >= kKept * r.recorded_share;
    if (r.used) {
      const Trajectory path = corrected(out.log.world_from_rig, found.path);
      r.largest_change_m = largest_change_m(out.log.world_from_rig, path);
      out.log = on_path(std::move(out.log), path);
    } else {
      r.reason = "sweeps agree no better on another";
    }
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kNumeric) throw;
    out.report.reason = error.what();
  }
  out.report.seconds = watch.seconds();
  return out;
}

}  // namespace simuli
