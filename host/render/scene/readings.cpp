#include "host/render/scene/readings.hpp"

#include <algorithm>
#include <utility>

namespace simuli {

float best_distance(const RayResults& results, std::size_t ray) {
  const bool has_median = !results.median.empty() && results.median[ray] > 0.0F;
  return has_median ? results.median[ray] : results.expected_distance(ray);
}

Image picture_of(const RayResults& results, const Camera& camera) {
  Image image(camera.width, camera.height, 3);
  for (std::size_t i = 0; i < results.rays; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      image.data[3 * i + c] = std::clamp(results.feature[c][i], 0.0F, 1.0F);
    }
  }
  return image;
}

std::ptrdiff_t LidarFrame::returns() const {
  return std::count_if(range.begin(), range.end(), [](float r) { return r > 0.0F; });
}

LidarFrame lidar_frame(const LidarModel& lidar, LidarRays rays, const RayResults& results) {
  LidarFrame out;
  for (std::size_t i = 0; i < results.rays; ++i) {
    const float drop = results.drop_probability(i);
    const bool returns = drop <= 0.5F;
    out.range.push_back(returns ? stated_range(lidar, rays, i, best_distance(results, i)) : 0.0F);
    out.intensity.push_back(returns ? std::clamp(results.feature[0][i], 0.0F, 1.0F) : 0.0F);
    out.drop.push_back(drop);
  }
  out.rays = std::move(rays);
  return out;
}

std::vector<Eigen::Vector3d> world_points(const LidarModel& lidar,
                                          const LidarFrame& frame,
                                          const Shot& shot) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(frame.range.size());
  for (std::size_t i = 0; i < frame.range.size(); ++i) {
    points.push_back(shot.pose_at(frame.rays.time_fraction[i]) *
                     (ray_origin(lidar, frame.rays, i) +
                      static_cast<double>(frame.range[i]) *
                          Lidar::direction(frame.rays.azimuth[i], frame.rays.elevation[i])));
  }
  return points;
}

}  // namespace simuli
