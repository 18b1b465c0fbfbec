#include "host/device/render/scene/readings.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/core/base/names.hpp"

namespace simuli {
namespace {

constexpr float kOneSurface_m = 0.15F;  // largest difference of median and mean for a single surface

}  // namespace

float best_distance(const RayResults& results, std::size_t ray) {
  const float mean_m = results.expected_distance(ray);
  if (results.median.empty() || !(results.median[ray] > 0.0F)) return mean_m;
  return std::abs(mean_m - results.median[ray]) <= kOneSurface_m ? mean_m : results.median[ray];
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

const std::vector<std::string>& point_frame_names() {
  static const std::vector<std::string> names{"world", "sensor", "sensor_start"};
  return names;
}

PointFrame point_frame(std::string_view name) {
  return static_cast<PointFrame>(index_of_name(name, point_frame_names(), "frame of points"));
}

std::vector<Eigen::Vector3d> points_of(const LidarModel& lidar,
                                       const LidarFrame& frame,
                                       const Shot& shot,
                                       PointFrame in) {
  const Pose start_from_world = shot.world_from_sensor_start.inverse();
  std::vector<Eigen::Vector3d> points;
  points.reserve(frame.range.size());
  for (std::size_t i = 0; i < frame.range.size(); ++i) {
    Eigen::Vector3d point = ray_origin(lidar, frame.rays, i) +
                            static_cast<double>(frame.range[i]) *
                                Lidar::direction(frame.rays.azimuth[i], frame.rays.elevation[i]);
    if (in != PointFrame::kSensor) point = shot.pose_at(frame.rays.time_fraction[i]) * point;
    if (in == PointFrame::kSensorStart) point = start_from_world * point;
    points.push_back(point);
  }
  return points;
}

}  // namespace simuli
