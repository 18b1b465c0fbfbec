#include "host/core/record/support_record.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <variant>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

constexpr int kCellPixels = 4, kMostCameraColumns = 80;
constexpr int kCellFirings = 4, kMostLidarColumns = 240, kMostLidarRows = 64;
constexpr double kSteepest = 8.0;  // limit of rows, 83 degrees up or down

struct GridPosition {
  double column = 0.0, row = 0.0;
};
GridPosition position_of(const Eigen::Vector3d& d) {
  const double side = d.y() / std::max(std::abs(d.x()) + std::abs(d.y()), 1e-9);
  const double behind = d.y() >= 0.0 ? 2.0 - side : -2.0 - side;
  return {d.x() >= 0.0 ? side : behind, d.z() / std::max(std::hypot(d.x(), d.y()), 1e-9)};
}

/// The grid's extent: slightly wider than its content.
class Extent {
 public:
  void add(const Eigen::Vector3d& direction) {
    const GridPosition p = position_of(direction);
    left_ = std::min(left_, p.column), right_ = std::max(right_, p.column);
    low_ = std::min(low_, p.row), high_ = std::max(high_, p.row);
  }
  void turn_round() { left_ = -2.0, right_ = 2.0; }
  [[nodiscard]] SupportGrid grid(int columns, int rows, double rays_per_rad) const {
    constexpr double kMargin = 1e-6;
    const double low = std::max(low_, -kSteepest) - kMargin, high = std::min(high_, kSteepest) + kMargin;
    return {columns,
            rows,
            left_ - kMargin,
            columns / (right_ - left_ + 2.0 * kMargin),
            high,
            rows / std::max(high - low, kMargin),
            rays_per_rad};
  }

 private:
  double left_ = 2.0, right_ = -2.0, low_ = 1e9, high_ = -1e9;
};

SupportGrid grid_of_lidar(const Lidar& lidar) {
  Extent extent;
  extent.turn_round();
  double low = 0.5 * std::numbers::pi, high = -low;
  for (const auto& row : lidar.rows) {
    low = std::min(low, row.elevation), high = std::max(high, row.elevation);
    extent.add(Lidar::direction(0.0, row.elevation));
  }
  // Half the angle between neighbouring beams.
  const int count = static_cast<int>(lidar.rows.size());
  const double step = count > 1 ? (high - low) / (count - 1) : 0.01;
  extent.add(Lidar::direction(0.0, low - 0.5 * step));
  extent.add(Lidar::direction(0.0, high + 0.5 * step));
  return extent.grid(std::clamp(lidar.columns / kCellFirings, 8, kMostLidarColumns),
                     std::clamp(count, 1, kMostLidarRows),
                     rays_per_rad(LidarModel(lidar)));
}

SupportGrid grid_of_list(const RayList& list) {
  Extent extent;
  extent.turn_round();
  for (std::size_t i = 0; i < list.azimuth.size(); ++i) extent.add(Lidar::direction(0.0, list.elevation[i]));
  return extent.grid(kMostLidarColumns, kMostLidarRows, rays_per_rad(LidarModel(list)));
}

}  // namespace

std::size_t SupportGrid::cell_of(const Eigen::Vector3d& direction) const {
  const GridPosition p = position_of(direction);
  const double column = (p.column - first_column) * columns_per_unit,
               row = (first_row - p.row) * rows_per_unit;
  if (!(column >= 0.0 && column < columns && row >= 0.0 && row < rows)) return cells();
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
}

SupportGrid support_grid(const Camera& camera) {
  Extent extent;
  const Pose grid_from = grid_from_camera();
  constexpr int kSteps = 64;
  for (int y = 0; y <= kSteps; ++y) {
    for (int x = 0; x <= kSteps; ++x) {
      const Eigen::Vector3d ray =
          camera.unproject({camera.width * (x / double{kSteps}), camera.height * (y / double{kSteps})});
      if (ray.squaredNorm() > 0.0) extent.add(grid_from.rotation * ray);
    }
  }
  const int columns = std::clamp(camera.width / kCellPixels, 1, kMostCameraColumns);
  const int rows = std::clamp(columns * camera.height / std::max(camera.width, 1), 1, 2 * kMostCameraColumns);
  return extent.grid(columns, rows, rays_per_rad(camera));
}

double rays_per_rad(const Camera& camera) { return 0.5 * (camera.fx + camera.fy); }

double rays_per_rad(const LidarModel& lidar) {
  if (const auto* rows = std::get_if<Lidar>(&lidar)) {
    return rows->columns / std::max(std::abs(rows->azimuth_span), 1e-3);
  }
  // As if the rays covered a quarter of the field of view.
  return std::max(0.5 * std::sqrt(static_cast<double>(ray_count(lidar))), 1.0);
}

SupportGrid support_grid(const LidarModel& lidar) {
  if (const auto* rows = std::get_if<Lidar>(&lidar)) return grid_of_lidar(*rows);
  return grid_of_list(std::get<RayList>(lidar));
}

Pose grid_from_camera() {
  Eigen::Matrix3d r;
  r << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Eigen::Quaterniond(r), Eigen::Vector3d::Zero()};
}

void validate(const SupportRecord& record, const std::string& where) {
  std::size_t cells = 0;
  for (std::size_t i = 0; i < record.views.size(); ++i) {
    const SupportView& view = record.views[i];
    const std::string field = fmt::format("support: views[{}]", i);
    if (view.sensor >= record.sensors.size()) {
      throw_input_error(
          where, field + ".sensor", fmt::format("{}", view.sensor), "the number of one of its sensors");
    }
    if (!std::isfinite(view.time_s)) throw_input_error(where, field + ".time_s", "no number", "finite");
    cells += record.sensors[view.sensor].grid.cells();
  }
  constexpr std::size_t kMostCells = std::size_t{1} << 24U;  // exactly representable in float
  if (cells != record.cells.size() || cells > kMostCells) {
    throw_input_error(where,
                      "support: cells",
                      fmt::format("{}", record.cells.size()),
                      fmt::format("{}, those of all views, at most {}", cells, kMostCells));
  }
  const bool is_sound = std::all_of(record.cells.begin(), record.cells.end(), [](const SupportCell& c) {
    return c.nearest_m >= 0.0F && c.farthest_m >= c.nearest_m && std::isfinite(c.farthest_m) &&
           std::isfinite(c.log_error) && std::isfinite(c.log_contrast);
  });
  if (!is_sound)
    throw_input_error(where, "support: cells", "distances or errors that are none", "finite ones");
}

}  // namespace simuli
