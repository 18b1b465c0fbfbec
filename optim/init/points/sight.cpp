#include "optim/init/points/sight.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <variant>

namespace simuli {
namespace {

/// Half of the angle between the beams above and below; for the outer beams the angle to their only neighbour.
std::vector<double> row_steps(const Lidar& lidar, double column_step_rad) {
  const std::vector<LidarRow>& rows = lidar.rows;
  std::vector<double> out(rows.size(), column_step_rad);
  if (rows.size() < 2) return out;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t above = i == 0 ? 0 : i - 1, below = std::min(i + 1, rows.size() - 1);
    out[i] = (rows[above].elevation - rows[below].elevation) / static_cast<double>(below - above);
  }
  return out;
}

/// For rays without rows: the side of a square with each ray's share of the solid angle.
double list_step(const RayList& list) {
  const auto [left, right] = std::minmax_element(list.azimuth.begin(), list.azimuth.end());
  const auto [low, high] = std::minmax_element(list.elevation.begin(), list.elevation.end());
  const double solid_angle = (*right - *left) * (std::sin(*high) - std::sin(*low));
  return std::sqrt(solid_angle / static_cast<double>(list.ray_count()));
}

}  // namespace

Sight Sight::turned(const Eigen::Quaternionf& to_from) const {
  return {range_m, to_from * towards, to_from * column_step, to_from * row_step};
}

Eigen::Vector3f Sight::column_step_on(const Eigen::Vector3f& normal) const {
  const float along = normal.dot(towards);
  const float safe = std::copysign(std::max(std::abs(along), kGrazing), along);
  return range_m * (column_step - towards * (normal.dot(column_step) / safe));
}

Eigen::Vector3f Sight::row_step_on(const Eigen::Vector3f& normal) const {
  const float along = normal.dot(towards);
  const float safe = std::copysign(std::max(std::abs(along), kGrazing), along);
  return range_m * (row_step - towards * (normal.dot(row_step) / safe));
}

bool is_nearer(const Sight& a, const Sight& b) {
  const auto key = [](const Sight& s) {
    return std::tuple(s.range_m,
                      s.towards.x(),
                      s.towards.y(),
                      s.towards.z(),
                      s.column_step.x(),
                      s.column_step.y(),
                      s.row_step.x(),
                      s.row_step.y());
  };
  return key(a) < key(b);
}

SightMaker::SightMaker(const LidarModel& lidar) {
  if (const auto* const spinning = std::get_if<Lidar>(&lidar)) {
    columns_ = static_cast<std::size_t>(spinning->columns);
    column_step_rad_ = spinning->azimuth_span / spinning->columns;
    row_step_rad_ = row_steps(*spinning, column_step_rad_);
    return;
  }
  const auto& list = std::get<RayList>(lidar);
  columns_ = std::max<std::size_t>(1, list.ray_count());
  column_step_rad_ = list_step(list);
  row_step_rad_ = {column_step_rad_};
}

Sight SightMaker::of(const LidarRays& rays,
                     std::size_t ray,
                     float range_m,
                     const Eigen::Quaterniond& scene_from_lidar) const {
  const double azimuth = rays.azimuth[ray], elevation = rays.elevation[ray];
  const Eigen::Vector3d across(-std::sin(azimuth), std::cos(azimuth), 0.0);
  const Eigen::Vector3d towards = Lidar::direction(azimuth, elevation);
  // A list has one row whose firings are not neighbours: both steps are equal.
  const double spread = row_step_rad_.size() > 1 ? std::cos(elevation) : 1.0;
  const Sight in_lidar{range_m,
                       towards.cast<float>(),
                       (spread * column_step_rad_ * across).cast<float>(),
                       (row_step_rad_[ray / columns_] * towards.cross(across)).cast<float>()};
  return in_lidar.turned(scene_from_lidar.cast<float>());
}

}  // namespace simuli
