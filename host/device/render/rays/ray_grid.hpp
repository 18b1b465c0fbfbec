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

/// All rays of a sensor in tiles of frame.tile_rays slots, in the sensor frame: the interface of sensor models
/// to later stages. A slot without a ray has ray_of_slot -1 and a zero direction.
struct RayGrid {
  SensorType type = SensorType::kCamera;
  shared::FrameParams frame{};  // particles and stride are set for each particle set
  LensKind lens = LensKind::kPinhole;     // of a camera
  int windshield = 0;  // in front of the lens: SIM_BEND_.. of cl/shared/sensor_constants.h
  int width = 0, height = 0;              // of a camera's picture, px
  bool lever_arms = false;                // rays start away from the sensor's origin
  std::size_t rays = 0;                   // pixels row-major, or LiDAR rays row-major
  std::size_t without_ray = 0;  // pixels without a ray through the lens, which have no slot
  std::vector<std::int32_t> ray_of_slot;  // [slots]
  std::vector<float> sensor_ray;          // [7][slots]: direction, origin (m), share of the frame
  std::vector<float>
      u;  // [slots]: px, or spin angle since the sweep's start (rad); also defined for slots without a ray
  std::vector<std::uint32_t> tile_rows;        // [tiles_y + 1]: first sensor row of each tile row
  std::vector<std::uint32_t> tile_row_of_row;  // LiDAR: [rows]
  std::vector<std::uint32_t> column_of_bin;    // LiDAR: tile column of each bin of x
  std::vector<std::int32_t> row_lut;  // LiDAR: elevation bin -> first row to test, [4096]
  std::vector<double> row_elevation;           // LiDAR: [2][rows] rad, lowest and highest ray
  shared::ModelConstants<double> model{};
  double view_angle = 0.0;  // camera: rad, half angle of the cone about the optical axis that contains all rays
};

/// Makes pixel tiles of 16 x 16. Pixels without a ray through the lens have no slot and show the background.
/// Throws Error{kInput} when no pixel has a ray.
[[nodiscard]] RayGrid make_ray_grid(const Camera& camera, const RayOptions& options);

/// Makes tiles of measured or nominal rays by procedure 1 on `device`. Throws Error{kInput} when `rays` is not
/// rows x columns of the model, or too uneven in azimuth.
[[nodiscard]] RayGrid make_ray_grid(const Device& device, const Lidar& lidar, const LidarRays& rays);

/// Makes tiles of rays without rows, sorted by elevation into rows that fill the tiles. A particle's box is
/// tested by such rows, not by ray. Throws Error{kInput} for a list that validate() refuses, or that needs more
/// than 65535 rows.
[[nodiscard]] RayGrid make_ray_grid(const Device& device, const RayList& list);

/// Makes the tiles of either kind of LiDAR for nominal or measured rays.
[[nodiscard]] RayGrid make_ray_grid(const Device& device, const LidarModel& model, const LidarRays& rays);

}  // namespace simuli
