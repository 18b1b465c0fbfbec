#pragma once
#include <cstdint>
#include <vector>

#include "cl/shared/layout.h"
#include "cl/shared/sensor_constants.h"
#include "host/core/base/pose.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/device/render/options/options.hpp"

namespace simuli {

class Device;

enum class SensorType : int { kCamera = 0, kLidar = 1 };  // as SENSOR in cl/math/sensor.h

/// All rays of a sensor laid into tiles of frame.tile_rays slots, in the sensor frame: what every later stage
/// needs to know of a sensor model. A slot without a ray has ray_of_slot -1 and a zero direction.
struct RayGrid {
  SensorType type = SensorType::kCamera;
  shared::FrameParams frame{};            // particles and stride are filled in per particle set
  LensKind lens = LensKind::kPinhole;     // of a camera
  int windshield = 0;                     // before it: SIM_BEND_.. of cl/shared/sensor_constants.h
  int width = 0, height = 0;              // of a camera's picture, px
  bool lever_arms = false;                // rays start away from the sensor's origin
  std::size_t rays = 0;                   // pixels row-major, or LiDAR rays row-major
  std::size_t without_ray = 0;            // pixels that the lens sees nothing through: no slot has them
  std::vector<std::int32_t> ray_of_slot;  // [slots]
  std::vector<float> sensor_ray;          // [7][slots]: direction, origin (m), share of the frame
  std::vector<float>
      u;  // [slots]: px, or spin angle since the sweep's start (rad); in the tile without a ray, too
  std::vector<std::uint32_t> tile_rows;        // [tiles_y + 1]: first sensor row of each tile row
  std::vector<std::uint32_t> tile_row_of_row;  // LiDAR: [rows]
  std::vector<std::uint32_t> column_of_bin;    // LiDAR: tile column of each bin of x
  std::vector<std::int32_t> row_lut;           // LiDAR: elevation bin -> first row to look at, [4096]
  std::vector<double> row_elevation;           // LiDAR: [2][rows] rad, lowest and highest ray
  shared::ModelConstants<double> model{};
  double view_angle = 0.0;  // camera: rad, half angle of the cone about the optical axis that holds all rays
};

/// Pixels in tiles of 16 x 16. A pixel through which the lens has no ray has no slot ray either: it stays in
/// the picture as background. Error{kInput} when no pixel has one.
[[nodiscard]] RayGrid make_ray_grid(const Camera& camera, const RayOptions& options);

/// Rays (measured or nominal) in the tiles of procedure 1, worked out on `device`. Error{kInput} when `rays`
/// is not rows x columns of the model, or too uneven in azimuth to be tiled.
[[nodiscard]] RayGrid make_ray_grid(const Device& device, const Lidar& lidar, const LidarRays& rays);

/// Rays without rows, sorted by elevation into rows of as many as the tiles hold. Within the box of a
/// particle the elevation is decided per such row, not per ray. Error{kInput} for a list that validate()
/// refuses, and for one that would need more than 65535 rows.
[[nodiscard]] RayGrid make_ray_grid(const Device& device, const RayList& list);

/// Either of the two with these rays, nominal or measured.
[[nodiscard]] RayGrid make_ray_grid(const Device& device, const LidarModel& model, const LidarRays& rays);

}  // namespace simuli
