#pragma once
// What sensors read of what their rays saw: pictures of cameras, returns of LiDARs.
#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/device/render/scene/ray_results.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli {

/// Distance of a LiDAR ray in m: the mean where the light is gone at one place, and where several surfaces
/// share it, so that it is far from where half of the light is gone, that median.
[[nodiscard]] float best_distance(const RayResults& results, std::size_t ray);

/// What a camera saw, as a picture clipped to [0, 1]: [height][width][3].
[[nodiscard]] Image picture_of(const RayResults& results, const Camera& camera);

/// What a LiDAR gives: a value per ray, row-major beams x firings.
struct LidarFrame {
  LidarRays rays;                // as fired
  std::vector<float> range;      // m from the ray's own origin, as the sensor states it; 0: no return
  std::vector<float> intensity;  // [0, 1]; 0: no return
  std::vector<float> drop;       // probability that the ray doesn't return

  [[nodiscard]] bool is_return(std::size_t ray) const { return range[ray] > 0.0F; }
  /// Number of rays that returned.
  [[nodiscard]] std::ptrdiff_t returns() const;
};

/// A ray returns when dropping it is at most as likely as not. Ranges include the row's range bias.
[[nodiscard]] LidarFrame lidar_frame(const LidarModel& lidar, LidarRays rays, const RayResults& results);

/// Whose axes points are in: the world's, the sensor's where it was at each ray's own time (as drivers state
/// them), or the sensor's where it was at the frame's start, its motion since then taken out.
enum class PointFrame { kWorld, kSensor, kSensorStart };
/// "world", "sensor", "sensor_start": in the order of the values.
[[nodiscard]] const std::vector<std::string>& point_frame_names();
/// Error{kUsage} naming those there are.
[[nodiscard]] PointFrame point_frame(std::string_view name);

/// Where the rays of a frame ended: [rays] m; of rays without a return the rays' origins.
[[nodiscard]] std::vector<Eigen::Vector3d> points_of(const LidarModel& lidar,
                                                     const LidarFrame& frame,
                                                     const Shot& shot,
                                                     PointFrame in);

}  // namespace simuli
