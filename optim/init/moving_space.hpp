#pragma once
// Where things moved through the log, and what of a frame shows them: training leaves those rays out, as a
// scene of the static background can only blur them.
#include <Eigen/Core>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "host/sensors/lidar_model.hpp"
#include "io/log/log.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/points/points.hpp"

namespace simuli {

/// The voxels in which something moved. Empty: nothing did.
class MovingSpace {
 public:
  MovingSpace() = default;
  /// From voxel averages and whether each moved. Voxels of kDense_m cells in which at least half of all
  /// voxels, and eight, moved: single ones are leaves in the wind and noise.
  MovingSpace(double voxel_m, const PointSet& points, const std::vector<bool>& moved);
  [[nodiscard]] bool contains(const Eigen::Vector3d& p_scene) const;
  [[nodiscard]] std::size_t voxels() const { return voxels_.size(); }

  static constexpr double kDense_m = 0.5;

 private:
  double voxel_m_ = 1.0;
  std::unordered_set<std::uint64_t> voxels_;
};

/// Returns of a sweep with the scene poses of its sensor at the start and the end.
struct MovingReturns {
  std::vector<bool> is_moving;           // [rays]
  std::vector<Eigen::Vector3d> p_scene;  // of those that are
};
[[nodiscard]] MovingReturns find_moving_returns(const MovingSpace& space,
                                                const Sweep& sweep,
                                                const LidarModel& lidar,
                                                const Pose& scene_from_lidar_start,
                                                const Pose& scene_from_lidar_end);

/// Pixels [height][width] within reach_m of such a return: bodies reflect in places only.
[[nodiscard]] std::vector<bool> moving_pixels(const ImageView& view,
                                              const std::vector<Eigen::Vector3d>& p_scene,
                                              double reach_m);

}  // namespace simuli
