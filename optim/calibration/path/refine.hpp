#pragma once
// Joint optimisation of all poses and planes, which makes odometry globally consistent.
#include <functional>
#include <optional>
#include <vector>

#include "host/core/sensors/trajectory.hpp"
#include "optim/calibration/path/returns.hpp"

namespace simuli::calibration {

/// External poses (GNSS/IMU) of the rig in the same world.
struct PathPrior {
  Trajectory world_from_rig;
  double sigma_m = 0.1;
  double sigma_rad = 0.0035;  // 0.2 degrees
};

struct RefineOptions {
  std::size_t points_per_sweep = 12000;  // matched points
  int rounds = 2;  // rounds of plane search and joint optimisation
};

struct RefineReport {
  std::size_t planes = 0;
  std::size_t residuals = 0;
  double sigma_m = 0.0;  // of points about their plane
  /// Standard deviations per axis of the motion between two knots, averaged over the path: m and rad.
  double step_sigma_m = 0.0;
  double step_sigma_rad = 0.0;
};

/// The first pose is fixed, or all follow the prior. Planes are voxels seen by at least three sweeps. Throws
/// Error{kNumeric} when there is nothing to solve or the solver fails.
RefineReport refine_path(const std::vector<Returns>& sweeps,
                         const std::optional<PathPrior>& prior,
                         const RefineOptions& options,
                         std::vector<TimedPose>& path,
                         const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace simuli::calibration
