#pragma once
// What a scene keeps of the frames that it was made of, so that it can tell how well it knows what it shows.
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
/// square |x| + |y| = 1, from behind by the right to the front and round by the left, in (-2, 2]; rows along
/// z over hypot(x, y), from the top. Each is parted evenly.
struct SupportGrid {
  int columns = 0, rows = 0;
  double first_column = 0.0, columns_per_unit = 0.0;
  double first_row = 0.0, rows_per_unit = 0.0;
  double rays_per_rad = 0.0;  // of the sensor, about its middle

  [[nodiscard]] std::size_t cells() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// The cell of a direction of any length; cells() outside of the grid.
  [[nodiscard]] std::size_t cell_of(const Eigen::Vector3d& direction) const;
  bool operator==(const SupportGrid&) const = default;
};
/// Grids that hold all rays of the sensor, of about 4 pixels or 4 x 1 firings a cell, at most 80 and 240
/// columns.
[[nodiscard]] SupportGrid support_grid(const Camera& camera);
[[nodiscard]] SupportGrid support_grid(const LidarModel& lidar);
/// Rays per radian about the middle of a sensor's view.
[[nodiscard]] double rays_per_rad(const Camera& camera);
[[nodiscard]] double rays_per_rad(const LidarModel& lidar);
/// x forward, y left, z up from a camera's own axes (x right, y down, z forward).
[[nodiscard]] Pose grid_from_camera();

/// What was met through a cell.
struct SupportCell {
  float nearest_m = 0.0F, farthest_m = 0.0F;  // 0, 0: no ray; kSupportFar_m: nothing was met
  float log_error = 0.0F;     // mean of ln of what the scene was off the recording, a colour's mean or m
  float log_contrast = 0.0F;  // mean of ln of how far the recorded colours of neighbours are apart; LiDARs: 0
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
  Pose world_from_view;  // half-way through the frame, in the grid's axes
};

struct SupportRecord {
  std::vector<SupportSensor> sensors;
  std::vector<SupportView> views;  // by sensor, then by time
  std::vector<Actor> actors;       // as they went when the frames were recorded
  std::vector<SupportCell> cells;  // of the views, one behind the other: [rows][columns]
};

/// Error{kInput} naming `where`, field, found and allowed: views of no sensor, another number of cells, what
/// is not finite.
void validate(const SupportRecord& record, const std::string& where);

}  // namespace simuli
