#pragma once
// LiDAR odometry: registers each sweep to the map of the sweeps before, with a pose at its start and one at its
// end, and motion-compensated points.
#include <cstddef>
#include <functional>
#include <vector>

#include "host/core/sensors/trajectory.hpp"
#include "optim/calibration/path/plane_map.hpp"
#include "optim/calibration/path/returns.hpp"

namespace simuli::calibration {

struct OdometryOptions {
  std::size_t points_per_sweep = 20000;  // matched points; the map uses all
  int iterations = 15;  // largest number of matching and solving rounds per sweep
  double fastest_m_per_s = 40.0;  // of the first sweep, whose motion is found by search
};

/// Returns the times of the trajectory's knots: every sweep's start, the last end, and the end of a sweep
/// before a pause of more than a hundredth of it. Throws Error{kInput} unless sweeps follow one another.
[[nodiscard]] std::vector<double> knot_times(const std::vector<Returns>& sweeps);

/// Index i of the segment [i, i + 1] of `path` for time_s; clamped at the ends.
[[nodiscard]] std::size_t segment_of(const std::vector<TimedPose>& path, double time_s);
/// p_rig at time_s in world.
[[nodiscard]] Eigen::Vector3d world_point(const std::vector<TimedPose>& path,
                                          const Eigen::Vector3d& p_rig,
                                          double time_s);

/// How the surfaces of one sweep constrain its motion: for a shift along each of three orthogonal directions
/// the mean square cosine to the points' normals, smallest first; for rotations the same relative to the lever
/// arm.
struct Constraint {
  double least_shift = 0.0;
  Eigen::Vector3d shift_direction = Eigen::Vector3d::UnitX();  // rig, unit
  double least_turn = 0.0;
  Eigen::Vector3d turn_axis = Eigen::Vector3d::UnitZ();  // rig, unit
};
[[nodiscard]] Constraint constraint_of(const std::vector<Eigen::Vector3d>& p_rig,
                                       const std::vector<Eigen::Vector3d>& normal_rig);

/// Returns the trajectory; the world is the rig's frame at the first knot. Throws Error{kNumeric} with sweep
/// and direction when its surfaces do not determine the motion (a blank wall, a tunnel), or with too few
/// returns. Calls progress(done, total) after every sweep.
[[nodiscard]] std::vector<TimedPose> find_path(
    const std::vector<Returns>& sweeps,
    const OdometryOptions& options,
    const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Distances (m, unsigned) of points from the planes of the map built from all sweeps along `path`.
struct Fit {
  double median_m = 0.0;
  double planar_share = 0.0;  // share of points in a voxel with a plane
  double outlier_share = 0.0;  // share of these farther than kOutlier_m from it
  static constexpr double kOutlier_m = 0.1;
};
[[nodiscard]] Fit fit_of(const std::vector<Returns>& sweeps, const std::vector<TimedPose>& path);

}  // namespace simuli::calibration
