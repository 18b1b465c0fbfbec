#pragma once
// The sweeps of one LiDAR in the scene: what stands above the ground, and what each looked through.
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

/// Above the ground: nothing on a road is higher.
inline constexpr double kHighest_m = 4.7;

/// One sweep: its firing grid as votes need it, and its returns that may be on something that drives.
struct SeriesSweep {
  double time_start_s = 0.0;
  double time_end_s = 0.0;
  Pose scene_from_lidar_start;
  Pose scene_from_lidar_end;
  Sweep seen;                        // ranges alone
  PointSet points;                   // [N] above the ground, one of each voxel of kThin_m
  std::vector<float> time_fraction;  // [N] of the sweep

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
  std::vector<SeriesSweep> sweeps;  // by time
  GroundMap ground;

  /// Lets sweep `index` vote on points of the scene (initialize_moving.hpp).
  void vote(std::size_t index, const PointSet& points, std::vector<PointVotes>& votes) const;
  /// When sweep `index` looks towards a point of the scene, s.
  [[nodiscard]] double looks_at_s(std::size_t index, const Eigen::Vector3d& p_scene) const;
};

/// The training sweeps of the log's LiDAR with rows that has most rays; none where no LiDAR has rows: a list
/// has no neighbouring rays to look through. Error{kInput} when a sweep can't be read.
[[nodiscard]] SweepSeries load_series(const Log& log, const HeldOutRule& rule);

}  // namespace simuli
