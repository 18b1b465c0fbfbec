#pragma once
// Walls above the laser for LiDARs that look higher than those of the drive: from above or from beside the
// path, or of another kind. No ray has met them, and none may have passed where they are.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/core/scene/gaussians.hpp"
#include "io/log/log.hpp"
#include "optim/init/init_options.hpp"
#include "optim/init/initialize_walls.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Where returns of upright walls (columns_of_walls()) end, and what rays say of the places above.
class WallsUpward {
 public:
  /// `points`: of the background, one per voxel of voxel_m. Walls go on by up_m at most.
  WallsUpward(const PointSet& points, double voxel_m, double up_m);
  /// Rays of a sweep that meet something behind a place, or nothing at all, end the wall below it. Lists of
  /// rays, whose neighbours aren't known, have no word.
  void look_through(const PosedSweep& posed);
  /// A point for each place that is left, cell_m() apart. A wall is no higher than most of its columns within
  /// 1.5 m. Nothing when no sweep had a word.
  [[nodiscard]] PointSet points() const;
  [[nodiscard]] double cell_m() const { return cell_m_; }

 private:
  [[nodiscard]] Eigen::Vector3d place(std::size_t column, std::size_t step) const;

  double cell_m_;
  std::size_t steps_;
  std::vector<WallColumn> columns_;
  std::vector<std::uint8_t> is_open_;  // [columns][steps] rays went on there
  bool is_asked_ = false;
};

/// LiDAR particles on them, by init.lidar_walls_m: none if that is 0. `points` as above, of the scene with
/// that origin; `step` is called after each of the sweeps. Error{kInput} when one can't be read.
[[nodiscard]] GaussianSet walls_upward(const Log& log,
                                       const std::vector<const SweepFrame*>& sweeps,
                                       const Eigen::Vector3d& origin,
                                       const PointSet& points,
                                       const InitOptions& options,
                                       const std::function<void()>& step);

}  // namespace simuli
