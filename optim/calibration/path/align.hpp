#pragma once
// The path of a log from its LiDAR: odometry, then a joint refinement of all poses.
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
  bool use_prior = false;  // the log's own poses are believed, as far as the sigmas say
  double prior_sigma_m = 0.1;
  double prior_sigma_rad = 0.0035;  // 0.2 degrees
  double near_m =
      0.0;  // with the prior: recorded poses whose surfaces are thinner are the start, without odometry
  double fine_m = 0.0;           // and below that they are the result
  std::size_t spin_sweeps = 10;  // for the spin direction; 0: not asked for
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
/// where the sweeps do not determine the path.
[[nodiscard]] AlignReport align_log(
    const Log& log,
    const AlignOptions& options = {},
    const std::function<void(const char*, std::size_t, std::size_t)>& progress = {});

/// Writes the log with another path (and whatever else was changed in it) to a new folder. Boxes of actors
/// were seen from the rig and go where it goes. Pictures and sweeps are hard links where the file system has
/// them, copies where not.
void write_aligned_log(const Log& log, const Trajectory& world_from_rig, const std::filesystem::path& folder);

}  // namespace simuli::calibration
