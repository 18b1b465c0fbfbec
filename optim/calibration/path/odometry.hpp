#pragma once
// Where the rig drove, from the LiDAR alone: each sweep is registered to the map of those before it with a
// pose at its start and one at its end, its points moved to where they were at their own time.
#include <cstddef>
#include <functional>
#include <vector>

#include "host/core/sensors/trajectory.hpp"
#include "optim/calibration/path/plane_map.hpp"
#include "optim/calibration/path/returns.hpp"

namespace simuli::calibration {

struct OdometryOptions {
  std::size_t points_per_sweep = 20000;  // looked up in the map, which takes all
  int iterations = 15;                   // of finding planes and solving, per sweep, at most
  double fastest_m_per_s = 40.0;         // of the first sweep, whose motion is found by trial
};

/// Times of the path's knots: every sweep's start, the last end, and the end of a sweep before a pause of
/// more than a hundredth of it. Throws Error{kInput} unless sweeps follow one another.
[[nodiscard]] std::vector<double> knot_times(const std::vector<Returns>& sweeps);

/// Number i of the segment [i, i + 1] of `path` for time_s; the first or the last for a time outside.
[[nodiscard]] std::size_t segment_of(const std::vector<TimedPose>& path, double time_s);
/// p_rig at time_s in world.
[[nodiscard]] Eigen::Vector3d world_point(const std::vector<TimedPose>& path,
                                          const Eigen::Vector3d& p_rig,
                                          double time_s);

/// What the surfaces of one sweep tell of its motion: for a shift along each of three orthogonal directions,
/// the share of points' normals that it moves off their plane (mean square cosine), least first; and for
/// turns, the same in terms of the lever arm.
struct Constraint {
  double least_shift = 0.0;
  Eigen::Vector3d shift_direction = Eigen::Vector3d::UnitX();  // rig, unit
  double least_turn = 0.0;
  Eigen::Vector3d turn_axis = Eigen::Vector3d::UnitZ();  // rig, unit
};
[[nodiscard]] Constraint constraint_of(const std::vector<Eigen::Vector3d>& p_rig,
                                       const std::vector<Eigen::Vector3d>& normal_rig);

/// World is the rig's frame at the first knot. Throws Error{kNumeric} naming the sweep and the direction
/// when its surfaces do not determine the motion (a blank wall, a tunnel), or when it has too few returns.
/// progress(done, total) is called after every sweep.
[[nodiscard]] std::vector<TimedPose> find_path(
    const std::vector<Returns>& sweeps,
    const OdometryOptions& options,
    const std::function<void(std::size_t, std::size_t)>& progress = {});

/// Distances (m, unsigned) of sweeps' points from the planes of the map made of all sweeps along `path`.
struct Fit {
  double median_m = 0.0;
  double planar_share = 0.0;   // of the points lie in a voxel with a plane
  double outlier_share = 0.0;  // of those are farther than kOutlier_m from it
  static constexpr double kOutlier_m = 0.1;
};
[[nodiscard]] Fit fit_of(const std::vector<Returns>& sweeps, const std::vector<TimedPose>& path);

}  // namespace simuli::calibration
