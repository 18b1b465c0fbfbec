#include "optim/calibration/path/align.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/log/frame_files.hpp"

namespace simuli::calibration {
namespace {

namespace fs = std::filesystem;

/// The log's recorded poses at the trajectory's knots.
std::vector<TimedPose> recorded_path(const Log& log, const std::vector<double>& knots_s) {
  std::vector<TimedPose> path;
  for (const double time_s : knots_s) path.push_back({time_s, log.world_from_rig.at(time_s)});
  return path;
}

}  // namespace

AlignReport align_log(const Log& log,
                      const AlignOptions& options,
                      const std::function<void(const char*, std::size_t, std::size_t)>& progress) {
  const auto begin = std::chrono::steady_clock::now();
  const auto report_stage = [&](const char* stage, std::size_t steps) {
    if (progress) progress(stage, 0, steps);
    return [&progress, stage](std::size_t done, std::size_t total) {
      if (progress) progress(stage, done, total);
    };
  };
  if (log.lidars.empty())
    throw_input_error((log.folder / "log.json").string(), "lidars", "none", "at least one");
  const Lidar& model = (options.lidar.empty() ? log.lidars.front() : log.lidar(options.lidar)).with_rows();

  AlignReport report;
  std::vector<Returns> sweeps;
  std::vector<Returns> reversed;
  std::vector<const SweepFrame*> frames;
  for (const SweepFrame& frame : log.sweeps) {
    if (frame.lidar == model.name) frames.push_back(&frame);
  }
  expect(log, frames);
  for (const SweepFrame* frame : frames) {
    sweeps.push_back(returns_of(log, *frame));
    report.returns += sweeps.back().size();
    if (reversed.size() < options.spin_sweeps) reversed.push_back(returns_of(log, *frame, true));
  }
  report.sweeps = sweeps.size();
  if (sweeps.size() < 2) {
    throw_input_error((log.folder / "log.json").string(),
                      "sweeps of lidar " + model.name,
                      std::to_string(sweeps.size()),
                      "at least 2");
  }
  if (options.spin_sweeps > 0) {
    const auto tell = report_stage("spin direction", 1);
    const std::vector<Returns> forward(sweeps.begin(),
                                       sweeps.begin() + static_cast<std::ptrdiff_t>(reversed.size()));
    const bool clockwise = model.spin == SpinDirection::kClockwise;
    report.spin = clockwise ? find_spin(forward, reversed, options.odometry)
                            : find_spin(reversed, forward, options.odometry);
    reversed.clear();
    tell(1, 1);
  }

  const std::vector<TimedPose> recorded = recorded_path(log, knot_times(sweeps));
  report.recorded = fit_of(sweeps, recorded);
  const bool near = options.use_prior && report.recorded.median_m < options.near_m;
  report.path =
      near ? recorded : find_path(sweeps, options.odometry, report_stage("odometry", sweeps.size()));
  report.odometry = near ? report.recorded : fit_of(sweeps, report.path);
  std::optional<PathPrior> prior;
  if (options.use_prior) {
    prior = PathPrior{log.world_from_rig, options.prior_sigma_m, options.prior_sigma_rad};
    // Odometry's world is transformed to the prior's at the log's first pose.
    const Pose prior_from_path = recorded.front().pose * report.path.front().pose.inverse();
    for (TimedPose& knot : report.path) knot.pose = prior_from_path * knot.pose;
    // With many moving objects odometry may fail where the recorded poses do not.
    if (report.recorded.planar_share > report.odometry.planar_share) report.path = recorded;
  }
  if (options.use_prior && report.recorded.median_m < options.fine_m) {
    report.path = recorded;
  } else {
    const auto rounds = static_cast<std::size_t>(options.refine.rounds);
    report.refinement =
        refine_path(sweeps, prior, options.refine, report.path, report_stage("joint refinement", rounds));
  }
  report.refined = fit_of(sweeps, report.path);
  for (std::size_t i = 1; i < report.path.size(); ++i) {
    report.length_m += (report.path[i].pose.translation - report.path[i - 1].pose.translation).norm();
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report;
}

void write_aligned_log(const Log& log, const Trajectory& world_from_rig, const fs::path& folder) {
  copy_log(on_path(log, world_from_rig), folder);
}

}  // namespace simuli::calibration
