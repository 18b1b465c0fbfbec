#include "host/core/sensors/lidar_locate.hpp"

#include <cmath>

#include "host/core/base/angles.hpp"

namespace simuli {
namespace {

bool in_sweep(const Lidar& lidar, const LidarHit& hit) {
  constexpr double kRounding = 1e-9;  // columns: a full revolution has no gap at its cut
  return hit.column >= -0.5 - kRounding && hit.column <= lidar.columns - 0.5 + kRounding;
}

}  // namespace

std::optional<LidarHit> locate_in_row(const Lidar& lidar, int row, const Eigen::Vector3d& p_sensor) {
  const LidarRow& beam = lidar.rows[static_cast<std::size_t>(row)];
  const double flat = std::hypot(p_sensor.x(), p_sensor.y());
  if (!(flat > std::abs(beam.horizontal_offset))) return std::nullopt;
  LidarHit hit;
  hit.row = row;
  // From above the ray is a line that passes the spin axis at the horizontal offset.
  hit.azimuth = std::atan2(p_sensor.y(), p_sensor.x()) - std::asin(beam.horizontal_offset / flat);
  const double along =
      std::sqrt((flat - beam.horizontal_offset) * (flat + beam.horizontal_offset)) - beam.radial_offset;
  if (!(along > 0.0)) return std::nullopt;
  const double height = p_sensor.z() - beam.vertical_offset;
  hit.elevation_error = std::atan2(height, along) - beam.elevation;
  hit.range = std::hypot(along, height);

  const double step = lidar.azimuth_span / lidar.columns;
  const double middle = (lidar.azimuth_span - step) / 2.0;
  const double turned = (hit.azimuth - lidar.azimuth_first - beam.azimuth_offset) * lidar.spin_sign();
  hit.column = (middle + std::remainder(turned - middle, 2.0 * kPi)) / step;
  hit.time_fraction = (hit.column + 0.5) / lidar.columns;
  hit.time_fraction += beam.time_offset / lidar.sweep_s;
  return in_sweep(lidar, hit) ? std::optional(hit) : std::nullopt;
}

std::optional<LidarHit> locate(const Lidar& lidar, const Eigen::Vector3d& p_sensor) {
  const double step = lidar.azimuth_span / lidar.columns;
  std::optional<LidarHit> best;
  double smallest = 0.0;
  for (int row = 0; row < lidar.row_count(); ++row) {
    const auto hit = locate_in_row(lidar, row, p_sensor);
    if (!hit) continue;
    const double elevation = lidar.rows[static_cast<std::size_t>(row)].elevation;
    const double sideways = (hit->column - std::round(hit->column)) * step * std::cos(elevation);
    const double angle = std::hypot(sideways, hit->elevation_error);
    if (!best || angle < smallest) {
      best = hit;
      smallest = angle;
    }
  }
  return best;
}

}  // namespace simuli
