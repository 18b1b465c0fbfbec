#pragma once
// The sweeps of one LiDAR in the scene: their returns above the ground, and their rays for votes.
#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "host/core/scene/ground/ground_map.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "optim/init/initialize_moving.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Height above the ground that no road vehicle exceeds.
inline constexpr double kHighest_m = 4.7;

/// One sweep: its firing grid for votes, and its returns that may belong to moving objects.
struct SeriesSweep {
  double time_start_s = 0.0;
  double time_end_s = 0.0;
  Pose scene_from_lidar_start;
  Pose scene_from_lidar_end;
  Sweep seen;  // only ranges
  PointSet points;  // [N] above the ground, one per voxel of kThin_m
  std::vector<float> time_fraction;  // [N] share of the sweep

  [[nodiscard]] double time_s(std::size_t point) const {
    return time_start_s + static_cast<double>(time_fraction[point]) * (time_end_s - time_start_s);
  }
  [[nodiscard]] double middle_s() const { return 0.5 * (time_start_s + time_end_s); }
  [[nodiscard]] Eigen::Vector3d position(std::size_t point) const {
    return points.position.col(static_cast<Eigen::Index>(point)).cast<double>();
  }
  static constexpr double kThin_m = 0.1;
};

struct SweepSeries {
  Lidar lidar;
  Eigen::Vector3d scene_origin = Eigen::Vector3d::Zero();
  std::vector<SeriesSweep> sweeps;  // sorted by time
  GroundMap ground;

  /// Adds the votes of sweep `index` on points of the scene (initialize_moving.hpp).
  void vote(std::size_t index, const PointSet& points, std::vector<PointVotes>& votes) const;
  /// Time in s at which sweep `index` passes the direction of a point of the scene.
  [[nodiscard]] double looks_at_s(std::size_t index, const Eigen::Vector3d& p_scene) const;
};

/// Loads the training sweeps of the LiDAR with rows that has most rays; empty without such a LiDAR, because ray
/// lists have no known neighbours. Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] SweepSeries load_series(const Log& log, const HeldOutRule& rule);

}  // namespace simuli
