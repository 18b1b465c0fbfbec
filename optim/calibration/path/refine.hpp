#pragma once
// All poses and all planes at once: what odometry did sweep by sweep is made consistent over the log.
#include <functional>
#include <optional>
#include <vector>

#include "host/core/sensors/trajectory.hpp"
#include "optim/calibration/path/returns.hpp"

namespace simuli::calibration {

/// Poses from elsewhere (GNSS/IMU), of the rig in the same world.
struct PathPrior {
  Trajectory world_from_rig;
  double sigma_m = 0.1;
  double sigma_rad = 0.0035;  // 0.2 degrees
};

struct RefineOptions {
  std::size_t points_per_sweep = 12000;  // looked up
  int rounds = 2;                        // of finding planes and solving for them and all poses
};

struct RefineReport {
  std::size_t planes = 0;
  std::size_t residuals = 0;
  double sigma_m = 0.0;  // of a point about its plane, as found
  /// Standard deviations per axis of the motion between two knots, their mean over the path: m and rad.
  double step_sigma_m = 0.0;
  double step_sigma_rad = 0.0;
};

/// The first pose stays, or all follow the prior. Planes are voxels that at least three sweeps see.
/// Throws Error{kNumeric} when the solver finds nothing to solve or fails.
RefineReport refine_path(const std::vector<Returns>& sweeps,
                         const std::optional<PathPrior>& prior,
                         const RefineOptions& options,
                         std::vector<TimedPose>& path,
                         const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli::calibration
