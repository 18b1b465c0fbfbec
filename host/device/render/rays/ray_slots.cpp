#include "host/device/render/rays/ray_slots.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "host/core/base/error.hpp"

namespace simuli::ray_slots {
namespace {

constexpr int kLutBins = 4096;

}  // namespace

void allocate(RayGrid& grid) {
  const std::size_t slots = std::size_t{grid.frame.tiles_x} * grid.frame.tiles_y * grid.frame.tile_rays;
  // Kernels index up to 7 rows of slots with 32 bits.
  if (slots > std::size_t{1} << 29U) {
    throw Error(ErrorKind::kInput, fmt::format("sensor: found {} ray slots, allowed 2^29", slots));
  }
  grid.frame.slots = static_cast<std::uint32_t>(slots);
  grid.ray_of_slot.assign(slots, -1);
  grid.sensor_ray.assign(7 * slots, 0.0F);
  grid.u.assign(slots, 0.0F);
}

void set_tiles(RayGrid& grid, const LidarTiles& tiling) {
  auto& frame = grid.frame;
  frame.tiles_x = tiling.columns;
  frame.tiles_y = static_cast<std::uint32_t>(tiling.tile_rows.size() - 1);
  frame.rows = static_cast<std::uint32_t>(tiling.rows());
  frame.tile_rays = SIM_TILE_RAYS;
  frame.row_slots = tiling.row_slots;
  grid.tile_rows = tiling.tile_rows;
  grid.tile_row_of_row = tiling.tile_row_of_row;
  grid.column_of_bin = tiling.column_of_bin;
  allocate(grid);
  for (std::size_t slot = 0; slot < grid.u.size(); ++slot) {
    const std::size_t column = slot / frame.tile_rays % frame.tiles_x;
    grid.u[slot] = static_cast<float>((tiling.column_begin(column) + tiling.column_begin(column + 1)) / 2.0);
  }
  auto& m = grid.model;
  m.tile_first = static_cast<double>(tiling.first);
  m.tile_last = tiling.column_begin(tiling.columns);
  m.tile_scale = static_cast<double>(tiling.scale);
  m.tile_bins = static_cast<double>(tiling.column_of_bin.size());
  m.period = 2.0 * std::numbers::pi;
}

void set_ray(RayGrid& grid,
             std::size_t slot,
             std::size_t ray,
             const Eigen::Vector3d& direction,
             const Eigen::Vector3d& origin,
             double time) {
  const std::size_t slots = grid.frame.slots;
  grid.ray_of_slot[slot] = static_cast<std::int32_t>(ray);
  for (std::size_t k = 0; k < 3; ++k) {
    grid.sensor_ray[k * slots + slot] = static_cast<float>(direction[static_cast<Eigen::Index>(k)]);
    grid.sensor_ray[(3 + k) * slots + slot] = static_cast<float>(origin[static_cast<Eigen::Index>(k)]);
  }
  grid.sensor_ray[6 * slots + slot] = static_cast<float>(time);
}

void fill_elevation_table(RayGrid& grid,
                          const std::vector<double>& lowest,
                          const std::vector<double>& highest) {
  grid.row_elevation = lowest;
  grid.row_elevation.insert(grid.row_elevation.end(), highest.begin(), highest.end());
  const double low = lowest.back();
  const double span = std::max(lowest.front() - low, 1e-6);
  const double bin = span / (kLutBins - 4);
  grid.model.lut_first = low - bin;
  grid.model.lut_scale = 1.0 / bin;
  grid.row_lut.resize(kLutBins);
  for (int b = 0; b < kLutBins; ++b) {
    // Rows certainly above everything in bin b, with one bin of slack for the device's rounding.
    const double edge = low - bin + (b + 2) * bin;
    const auto above =
        std::partition_point(lowest.begin(), lowest.end(), [&](double e) { return e >= edge; });
    grid.row_lut[static_cast<std::size_t>(b)] = static_cast<std::int32_t>(above - lowest.begin());
  }
}

double beam_variance(double beam_divergence, double divergence_variance) {
  const double half_divergence = std::tan(beam_divergence / 2.0);
  return divergence_variance * half_divergence * half_divergence;
}

double rays_per_rad(std::size_t rays, double lowest, double highest, double span) {
  const auto count = static_cast<double>(rays);
  // A single row has no height: assumes the spacing along the row.
  const double height = std::max(std::sin(highest) - std::sin(lowest), span / count);
  return std::sqrt(count / (span * height));
}

}  // namespace simuli::ray_slots
