#include "host/core/sensors/lidar_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace simuli {
namespace {

/// Recorded minus true distance of a ray, m.
float range_bias(const LidarModel& model, const LidarRays& rays, std::size_t ray) {
  const auto* const lidar = std::get_if<Lidar>(&model);
  if (lidar == nullptr) return 0.0F;
  return static_cast<float>(lidar->rows[ray / static_cast<std::size_t>(rays.columns)].range_bias);
}

}  // namespace

const std::string& name_of(const LidarModel& model) {
  return std::visit([](const auto& m) -> const std::string& { return m.name; }, model);
}

std::size_t row_count(const LidarModel& model) {
  const auto* const lidar = std::get_if<Lidar>(&model);
  return lidar == nullptr ? 1 : lidar->rows.size();
}

std::size_t ray_count(const LidarModel& model) {
  return std::visit([](const auto& m) { return m.ray_count(); }, model);
}

double range_min(const LidarModel& model) {
  return std::visit([](const auto& m) { return m.range_min; }, model);
}

double range_max(const LidarModel& model) {
  return std::visit([](const auto& m) { return m.range_max; }, model);
}

double sweep_s(const LidarModel& model) {
  return std::visit([](const auto& m) { return m.sweep_s; }, model);
}

LidarRays nominal_rays(const LidarModel& model) {
  if (const auto* const lidar = std::get_if<Lidar>(&model)) return nominal_rays(*lidar);
  const auto& list = std::get<RayList>(model);
  LidarRays rays{1, static_cast<int>(list.ray_count()), {}, {}, {}};
  for (std::size_t i = 0; i < list.ray_count(); ++i) {
    rays.azimuth.push_back(static_cast<float>(std::remainder(list.azimuth[i], 2.0 * std::numbers::pi)));
    rays.elevation.push_back(static_cast<float>(list.elevation[i]));
    rays.time_fraction.push_back(static_cast<float>(list.time_fraction[i]));
  }
  return rays;
}

Eigen::Vector3d ray_origin(const LidarModel& model, const LidarRays& rays, std::size_t ray) {
  if (const auto* const list = std::get_if<RayList>(&model)) return list->ray_origin(ray);
  const auto row = static_cast<int>(ray / static_cast<std::size_t>(rays.columns));
  return std::get<Lidar>(model).origin(row, static_cast<double>(rays.azimuth[ray]));
}

bool is_blind(const LidarModel& model, const LidarRays& rays, std::size_t ray) {
  const auto* const lidar = std::get_if<Lidar>(&model);
  return lidar != nullptr && lidar->has_blind() &&
         is_blind(*lidar, ray, static_cast<double>(rays.azimuth[ray]));
}

bool hits_ego_vehicle(const LidarModel& model, const LidarRays& rays, std::size_t ray) {
  const auto* const lidar = std::get_if<Lidar>(&model);
  if (lidar == nullptr || lidar->blind.empty()) return false;
  const BlindArc* const arc = blind_arc_of(*lidar, ray, static_cast<double>(rays.azimuth[ray]));
  return arc != nullptr && arc->own_returns;
}

float stated_range(const LidarModel& model, const LidarRays& rays, std::size_t ray, float distance_m) {
  return distance_m + range_bias(model, rays, ray);
}

float distance_of(const LidarModel& model, const LidarRays& rays, std::size_t ray, float stated_range_m) {
  return stated_range_m - range_bias(model, rays, ray);
}

RayList with_rays(RayList list, const LidarRays& rays) {
  constexpr double kRight = std::numbers::pi / 2.0;  // the float value is larger
  list.azimuth.assign(rays.azimuth.begin(), rays.azimuth.end());
  list.elevation.assign(rays.elevation.begin(), rays.elevation.end());
  for (double& elevation : list.elevation) elevation = std::clamp(elevation, -kRight, kRight);
  list.time_fraction.assign(rays.time_fraction.begin(), rays.time_fraction.end());
  return list;
}

void validate(const LidarModel& model, const std::string& file) {
  std::visit([&](const auto& m) { validate(m, file); }, model);
}

}  // namespace simuli
