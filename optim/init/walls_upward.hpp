#pragma once
// Walls above the LiDARs' field of view, for rendering LiDARs that look higher: mounted higher, off the
// trajectory, or of another kind. No ray has hit them, and no ray may have passed through them.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/core/scene/gaussians.hpp"
#include "io/log/log.hpp"
#include "optim/init/init_options.hpp"
#include "optim/init/initialize_walls.hpp"
#include "optim/init/points/points.hpp"
#include "optim/init/posed_frames.hpp"

namespace simuli {

/// Columns of walls (columns_of_walls()) where returns end, and evidence of rays above them.
class WallsUpward {
 public:
  /// `points`: background, one per voxel of voxel_m. Walls continue by at most up_m.
  WallsUpward(const PointSet& points, double voxel_m, double up_m);
  /// Ends walls below positions that rays of the sweep pass (return from behind, or drop). Ignores ray lists,
  /// whose neighbours are unknown.
  void look_through(const PosedSweep& posed);
  /// Returns a point for each remaining position, cell_m() apart. A wall is no higher than the median of its
  /// columns within 1.5 m. Empty without any evidence.
  [[nodiscard]] PointSet points() const;
  [[nodiscard]] double cell_m() const { return cell_m_; }

 private:
  [[nodiscard]] Eigen::Vector3d place(std::size_t column, std::size_t step) const;

  double cell_m_;
  std::size_t steps_;
  std::vector<WallColumn> columns_;
  std::vector<std::uint8_t> is_open_;  // [columns][steps] rays passed there
  bool is_requested_ = false;
};

/// Returns LiDAR particles on these walls, by init.lidar_walls_m: none if that is 0. `points` as above, in the
/// scene with that origin; calls `step` after each sweep. Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] GaussianSet walls_upward(const Log& log,
                                       const std::vector<const SweepFrame*>& sweeps,
                                       const Eigen::Vector3d& origin,
                                       const PointSet& points,
                                       const InitOptions& options,
                                       const std::function<void()>& step);

}  // namespace simuli
