#include "optim/init/moving_space.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace simuli {
namespace {

constexpr std::uint32_t kLeastMoved = 8;  // voxels of a dense cell

/// 21 bits per axis hold the 2^20 voxels either way that VoxelGrid allows.
std::uint64_t key_of(const Eigen::Vector3d& p_scene, double side_m) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<std::int64_t>(std::floor(p_scene(axis) / side_m)) + (1 << 20);
    key = key << 21U | (static_cast<std::uint64_t>(index) & 0x1fffffU);
  }
  return key;
}

}  // namespace

MovingSpace::MovingSpace(double voxel_m, const PointSet& points, const std::vector<bool>& moved)
    : voxel_m_(voxel_m) {
  struct Count {
    std::uint32_t moved = 0;
    std::uint32_t all = 0;
  };
  const double dense_m = std::max(kDense_m, voxel_m);
  std::unordered_map<std::uint64_t, Count> cells;
  const auto position = [&](std::size_t i) -> Eigen::Vector3d {
    return points.position.col(static_cast<Eigen::Index>(i)).cast<double>();
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    Count& count = cells[key_of(position(i), dense_m)];
    count.moved += moved[i] ? 1U : 0U;
    ++count.all;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!moved[i]) continue;
    const Count& count = cells.at(key_of(position(i), dense_m));
    if (count.moved >= kLeastMoved && 2 * count.moved >= count.all)
      voxels_.insert(key_of(position(i), voxel_m));
  }
}

bool MovingSpace::contains(const Eigen::Vector3d& p_scene) const {
  return !voxels_.empty() && voxels_.contains(key_of(p_scene, voxel_m_));
}

MovingReturns find_moving_returns(const MovingSpace& space,
                                  const Sweep& sweep,
                                  const LidarModel& lidar,
                                  const Pose& scene_from_lidar_start,
                                  const Pose& scene_from_lidar_end) {
  MovingReturns out;
  out.is_moving.assign(sweep.range.size(), false);
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (!(sweep.range[i] > 0.0F)) continue;
    const Pose scene_from_lidar =
        interpolate(scene_from_lidar_start, scene_from_lidar_end, sweep.rays.time_fraction[i]);
    const Eigen::Vector3d p_lidar = ray_origin(lidar, sweep.rays, i) +
                                    static_cast<double>(sweep.range[i]) *
                                        Lidar::direction(sweep.rays.azimuth[i], sweep.rays.elevation[i]);
    const Eigen::Vector3d p_scene = scene_from_lidar * p_lidar;
    if (!space.contains(p_scene)) continue;
    out.is_moving[i] = true;
    out.p_scene.push_back(p_scene);
  }
  return out;
}

std::vector<bool> moving_pixels(const ImageView& view,
                                const std::vector<Eigen::Vector3d>& p_scene,
                                double reach_m) {
  const int width = view.camera().width;
  const int height = view.camera().height;
  std::vector<bool> mask(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), false);
  for (const Eigen::Vector3d& p : p_scene) {
    Eigen::Vector2d pixel;
    double range_m = 0.0;
    if (!view.project(p, pixel, range_m)) continue;
    const double radius = reach_m / (view.pixel_size_at_1m() * range_m);
    const auto first = [radius](double at) { return std::max(0, static_cast<int>(std::floor(at - radius))); };
    const auto last = [radius](double at, int side) {
      return std::min(side - 1, static_cast<int>(std::floor(at + radius)));
    };
    for (int y = first(pixel.y()); y <= last(pixel.y(), height); ++y) {
      for (int x = first(pixel.x()); x <= last(pixel.x(), width); ++x) {
        const double distance = std::hypot(x + 0.5 - pixel.x(), y + 0.5 - pixel.y());
        if (distance > radius) continue;
        mask[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
            true;
      }
    }
  }
  return mask;
}

}  // namespace simuli
