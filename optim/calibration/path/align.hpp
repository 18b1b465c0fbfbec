#pragma once
// Estimates the trajectory of a log from its LiDAR: odometry, then joint refinement of all poses.
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "io/log/log.hpp"
#include "optim/calibration/path/odometry.hpp"
#include "optim/calibration/path/refine.hpp"
#include "optim/calibration/path/spin.hpp"

namespace simuli::calibration {

struct AlignOptions {
  std::string lidar;       // name; empty: the log's first
  bool use_prior = false;  // use the log's recorded poses as a prior, with the sigmas below
  double prior_sigma_m = 0.1;
  double prior_sigma_rad = 0.0035;  // 0.2 degrees
  double near_m =
      0.0;  // with the prior: recorded poses with thinner surfaces are the start, without odometry
  double fine_m = 0.0;  // recorded poses with thinner surfaces are the result
  std::size_t spin_sweeps = 10;  // sweeps for the spin direction; 0: not estimated
  OdometryOptions odometry;
  RefineOptions refine;
};

struct AlignReport {
  std::vector<TimedPose> path;
  std::size_t sweeps = 0;
  std::size_t returns = 0;
  double length_m = 0.0;
  Fit recorded;  // with the poses of the log
  Fit odometry;
  Fit refined;
  RefineReport refinement;
  SpinReport spin;
  double seconds = 0.0;
};

/// progress(stage, done, total). Throws Error{kInput} for a log without sweeps of the LiDAR, Error{kNumeric}
/// when the sweeps do not determine the trajectory.
[[nodiscard]] AlignReport align_log(
    const Log& log,
    const AlignOptions& options = {},
    const std::function<void(const char*, std::size_t, std::size_t)>& progress = {});

/// Writes the log with another trajectory (and other changes) to a new folder. Actors' boxes move with the rig.
/// Pictures and sweeps are hard links where the file system supports them, otherwise copies.
void write_aligned_log(const Log& log, const Trajectory& world_from_rig, const std::filesystem::path& folder);

}  // namespace simuli::calibration
