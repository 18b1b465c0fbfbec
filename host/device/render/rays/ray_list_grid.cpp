// Tiles of rays without rows: sorted by elevation and cut into rows that fill the tiles.
#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/device/render/rays/ray_slots.hpp"

namespace simuli {
namespace {

// The device uses float elevations: rows extend slightly beyond their rays.
constexpr double kElevationSlack_rad = 1e-6;

/// The middle of the largest azimuth gap, where the cut separates no neighbouring rays.
double widest_gap(const RayList& list) {
  std::vector<double> sorted;
  sorted.reserve(list.ray_count());
  for (const double azimuth : list.azimuth) sorted.push_back(std::remainder(azimuth, kTurn));
  std::sort(sorted.begin(), sorted.end());
  double gap = sorted.front() + kTurn - sorted.back();
  double middle = sorted.back() + gap / 2.0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] - sorted[i - 1] > gap) {
      gap = sorted[i] - sorted[i - 1];
      middle = sorted[i - 1] + gap / 2.0;
    }
  }
  return std::remainder(middle, kTurn);
}

void set_constants(RayGrid& grid, const RayList& list, double cut, const std::vector<float>& angles) {
  auto& m = grid.model;
  const auto [lowest, highest] = std::minmax_element(list.elevation.begin(), list.elevation.end());
  const auto [first, last] = std::minmax_element(angles.begin(), angles.end());
  const double span = std::max(static_cast<double>(*last) - static_cast<double>(*first), 1e-3);
  m.rays_per_rad = ray_slots::rays_per_rad(list.ray_count(), *lowest, *highest, span);
  m.azimuth_cut = cut;
  m.spin = 1.0;
  // Time does not follow azimuth: the mid time, plus or minus half the time span.
  const auto [early, late] = std::minmax_element(list.time_fraction.begin(), list.time_fraction.end());
  m.inv_span = 0.0;
  m.time_first = (*early + *late) / 2.0;
  m.time_spread = (*late - *early) / 2.0;

  double height = 0.0;
  for (const Eigen::Vector3d& origin : list.origin)
    height += origin.z() / static_cast<double>(list.ray_count());
  double lever = 0.0;
  for (const Eigen::Vector3d& origin : list.origin) {
    lever = std::max(lever, (origin - Eigen::Vector3d(0.0, 0.0, height)).norm());
    grid.lever_arms = grid.lever_arms || !origin.isZero(0.0);
  }
  m.height = height;
  m.lever = lever;
  m.kappa = ray_slots::beam_variance(list.beam_divergence, list.divergence_variance);
  m.t_min = list.range_min;
  m.t_max = list.range_max;
}

}  // namespace

RayGrid make_ray_grid(const Device& device, const RayList& list) {
  validate(list, "sensor");
  RayGrid grid;
  grid.type = SensorType::kLidar;
  grid.rays = list.ray_count();

  const double cut = widest_gap(list);
  std::vector<float> angles(grid.rays);
  for (std::size_t i = 0; i < grid.rays; ++i) {
    const double turned = list.azimuth[i] - cut;
    angles[i] = static_cast<float>(turned - kTurn * std::floor(turned / kTurn));
  }
  const LidarTiles tiling =
      tile_ray_list(device, list.name, {list.elevation.begin(), list.elevation.end()}, angles);
  ray_slots::set_tiles(grid, tiling);
  for (std::size_t ray = 0; ray < grid.rays; ++ray) {
    const std::size_t slot = tiling.slot_of_ray[ray];
    ray_slots::set_ray(grid, slot, ray, list.direction(ray), list.ray_origin(ray), list.time_fraction[ray]);
    grid.u[slot] = angles[ray];
  }

  // Rows were sorted in float: in double neighbouring rows may overlap by its rounding.
  const std::size_t rows = tiling.rows();
  std::vector<double> lowest(rows), highest(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const auto begin = tiling.order.begin() + tiling.row_starts[row];
    const auto end = tiling.order.begin() + tiling.row_starts[row + 1];
    const auto [low, high] = std::minmax_element(
        begin, end, [&](std::uint32_t a, std::uint32_t b) { return list.elevation[a] < list.elevation[b]; });
    lowest[row] = list.elevation[*low] - kElevationSlack_rad;
    highest[row] = list.elevation[*high] + kElevationSlack_rad;
    if (row > 0) lowest[row] = std::min(lowest[row], lowest[row - 1]);
  }
  for (std::size_t row = rows - 1; row > 0; --row)
    highest[row - 1] = std::max(highest[row - 1], highest[row]);
  ray_slots::fill_elevation_table(grid, lowest, highest);
  set_constants(grid, list, cut, angles);
  return grid;
}

RayGrid make_ray_grid(const Device& device, const LidarModel& model, const LidarRays& rays) {
  if (const auto* const lidar = std::get_if<Lidar>(&model)) return make_ray_grid(device, *lidar, rays);
  const auto& list = std::get<RayList>(model);
  if (rays.azimuth.size() != list.ray_count()) {
    throw_input_error("ray list " + list.name,
                      "rays",
                      std::to_string(rays.azimuth.size()),
                      std::to_string(list.ray_count()) + " as the list");
  }
  return make_ray_grid(device, with_rays(list, rays));
}

}  // namespace simuli
