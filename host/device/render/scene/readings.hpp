#pragma once
// Measurements of sensors from their rays' results: pictures of cameras, returns of LiDARs.
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

/// Distance of a LiDAR ray in m: the mean for a single surface; the median where several surfaces share the
/// ray, so that the mean is far from it.
[[nodiscard]] float best_distance(const RayResults& results, std::size_t ray);

/// Returns a camera's picture, clipped to [0, 1]: [height][width][3].
[[nodiscard]] Image picture_of(const RayResults& results, const Camera& camera);

/// Measurements of a LiDAR: one value per ray, row-major beams x firings.
struct LidarFrame {
  LidarRays rays;                // as fired
  std::vector<float> range;  // m from the ray's own origin, including range bias; 0: no return
  std::vector<float> intensity;  // [0, 1]; 0: no return
  std::vector<float> drop;  // ray-drop probability

  [[nodiscard]] bool is_return(std::size_t ray) const { return range[ray] > 0.0F; }
  /// Number of rays that returned.
  [[nodiscard]] std::ptrdiff_t returns() const;
};

/// A ray returns if its ray-drop probability is at most 1/2. Ranges include the row's range bias.
[[nodiscard]] LidarFrame lidar_frame(const LidarModel& lidar, LidarRays rays, const RayResults& results);

/// Frame of points: world; the sensor at each ray's own time (as drivers report points); or the sensor at the
/// frame's start, with motion compensated.
enum class PointFrame { kWorld, kSensor, kSensorStart };
/// Returns "world", "sensor", "sensor_start", in the order of the values.
[[nodiscard]] const std::vector<std::string>& point_frame_names();
/// Throws Error{kUsage} with the known names.
[[nodiscard]] PointFrame point_frame(std::string_view name);

/// Returns the end points of a frame's rays: [rays] m; for rays without a return the rays' origins.
[[nodiscard]] std::vector<Eigen::Vector3d> points_of(const LidarModel& lidar,
                                                     const LidarFrame& frame,
                                                     const Shot& shot,
                                                     PointFrame in);

}  // namespace simuli
