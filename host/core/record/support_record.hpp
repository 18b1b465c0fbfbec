#pragma once
// Record of the training frames of a scene, from which support is computed.
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/actor.hpp"
#include "host/core/scene/gaussians.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"

namespace simuli {

/// A grid over the directions of a sensor, in axes x forward, y left, z up: columns along the sides of the
/// square |x| + |y| = 1, from behind via the right to the front and the left, in (-2, 2]; rows along z over
/// hypot(x, y), from the top. Both are uniform.
struct SupportGrid {
  int columns = 0, rows = 0;
  double first_column = 0.0, columns_per_unit = 0.0;
  double first_row = 0.0, rows_per_unit = 0.0;
  double rays_per_rad = 0.0;  // at the middle of the field of view

  [[nodiscard]] std::size_t cells() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// Returns the cell of a direction of any length; cells() outside of the grid.
  [[nodiscard]] std::size_t cell_of(const Eigen::Vector3d& direction) const;
  bool operator==(const SupportGrid&) const = default;
};
/// Returns a grid that contains all rays of the sensor, with about 4 pixels or 4 x 1 firings per cell and at
/// most 80 and 240 columns.
[[nodiscard]] SupportGrid support_grid(const Camera& camera);
[[nodiscard]] SupportGrid support_grid(const LidarModel& lidar);
/// Returns the rays per radian at the middle of a sensor's field of view.
[[nodiscard]] double rays_per_rad(const Camera& camera);
[[nodiscard]] double rays_per_rad(const LidarModel& lidar);
/// Transform from camera axes (x right, y down, z forward) to x forward, y left, z up.
[[nodiscard]] Pose grid_from_camera();

/// Observations through a cell.
struct SupportCell {
  float nearest_m = 0.0F, farthest_m = 0.0F;  // 0, 0: no ray; kSupportFar_m: no hit
  float log_error = 0.0F;  // mean of ln of the scene's error, of a colour (mean over channels) or in m
  float log_contrast = 0.0F;  // mean of ln of the contrast of neighbouring recorded colours; LiDARs: 0
};
inline constexpr double kSupportFar_m = 1e6;

struct SupportSensor {
  std::string name;
  SetKind kind = SetKind::kCamera;
  SupportGrid grid;
};

/// One recorded frame.
struct SupportView {
  std::size_t sensor = 0;  // index into SupportRecord::sensors
  double time_s = 0.0;
  Pose world_from_view;  // at mid-frame, in the grid's axes
};

struct SupportRecord {
  std::vector<SupportSensor> sensors;
  std::vector<SupportView> views;  // by sensor, then by time
  std::vector<Actor> actors;  // as recorded
  std::vector<SupportCell> cells;  // of all views, consecutive: [rows][columns]
};

/// Throws Error{kInput} with `where`, field, found and allowed value: views without sensor, wrong number of
/// cells, non-finite values.
void validate(const SupportRecord& record, const std::string& where);

}  // namespace simuli
