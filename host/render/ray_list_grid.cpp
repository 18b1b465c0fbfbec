// Rays without rows in tiles: sorted by elevation and cut into rows of as many rays as the tiles hold.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>

#include "host/base/error.hpp"
#include "host/render/ray_slots.hpp"

namespace simuli {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::size_t kMostRows = 65535;  // footprints hold rows in 16 bits
// Elevations in float on the device: rows are a hair higher than their rays.
constexpr double kElevationSlack_rad = 1e-6;

/// The middle of the largest gap between the azimuths, where no ray is cut off from its neighbours.
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

/// Rays in `order` cut into rows so that no tile column of a row holds more than `width`.
struct Packing {
  std::size_t columns = 0;              // of tiles
  double first = 0.0;                   // rad, where the first tile starts
  double tile_width = 0.0;              // rad
  std::vector<std::size_t> row_starts;  // [rows + 1] into `order`

  [[nodiscard]] std::size_t rows() const { return row_starts.size() - 1; }
  [[nodiscard]] std::size_t column(double angle) const {
    const double place = (angle - first) / tile_width;
    return std::min(static_cast<std::size_t>(std::max(place, 0.0)), columns - 1);
  }
};

Packing pack(const std::vector<double>& angles,
             const std::vector<std::size_t>& order,
             std::size_t columns,
             std::size_t width) {
  const auto [low, high] = std::minmax_element(angles.begin(), angles.end());
  // A hair more than the rays, so that the last one is inside.
  Packing packing{columns, *low, (*high - *low + 1e-6) / static_cast<double>(columns), {0}};
  std::vector<std::size_t> used(columns, 0);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t column = packing.column(angles[order[i]]);
    if (used[column] == width) {
      packing.row_starts.push_back(i);
      std::fill(used.begin(), used.end(), std::size_t{0});
    }
    ++used[column];
  }
  packing.row_starts.push_back(order.size());
  return packing;
}

/// The packing of fewest slots among tile columns about as wide as tiles are high.
Packing best_packing(const RayList& list,
                     const std::vector<double>& angles,
                     const std::vector<std::size_t>& order,
                     std::size_t rows_per_tile,
                     std::size_t width) {
  const auto [low, high] = std::minmax_element(angles.begin(), angles.end());
  const double wide = std::max(*high - *low, 1e-3);
  const double tall = std::max(list.elevation[order.front()] - list.elevation[order.back()], 1e-3);
  const double tiles = static_cast<double>(angles.size()) / SIM_TILE_RAYS;
  const double square = std::sqrt(tiles * wide / tall);
  Packing best;
  std::size_t fewest = 0;
  // At least 8: in wider tiles the two places of a particle at the cut could not be told apart.
  for (const double factor : {0.5, 0.6, 0.7, 0.85, 1.0, 1.2, 1.4, 1.7, 2.0}) {
    const auto columns = static_cast<std::size_t>(std::clamp(square * factor, 8.0, 16384.0));
    if (columns == best.columns) continue;
    Packing packing = pack(angles, order, columns, width);
    const std::size_t tiles_y = (packing.rows() + rows_per_tile - 1) / rows_per_tile;
    const std::size_t slots = tiles_y * columns * SIM_TILE_RAYS;
    if (best.columns == 0 || slots < fewest) {
      best = std::move(packing);
      fewest = slots;
    }
  }
  return best;
}

void set_constants(RayGrid& grid, const RayList& list, double cut, const Packing& packing) {
  auto& c = grid.constants;
  c[SIM_S_TILE_X0] = packing.first;
  c[SIM_S_TILE_SCALE] = 1.0 / packing.tile_width;
  c[SIM_S_PERIOD] = kTurn;
  c[SIM_S_AZIMUTH_CUT] = cut;
  c[SIM_S_SPIN] = 1.0;
  // Time does not follow the azimuth: the middle of all times, give or take half of their span.
  const auto [early, late] = std::minmax_element(list.time_fraction.begin(), list.time_fraction.end());
  c[SIM_S_INV_SPAN] = 0.0;
  c[SIM_S_TIME_FIRST] = (*early + *late) / 2.0;
  c[SIM_S_TIME_SPREAD] = (*late - *early) / 2.0;

  double height = 0.0;
  for (const Eigen::Vector3d& origin : list.origin)
    height += origin.z() / static_cast<double>(list.ray_count());
  double lever = 0.0;
  for (const Eigen::Vector3d& origin : list.origin) {
    lever = std::max(lever, (origin - Eigen::Vector3d(0.0, 0.0, height)).norm());
    grid.lever_arms = grid.lever_arms || !origin.isZero(0.0);
  }
  c[SIM_S_HEIGHT_REF] = height;
  c[SIM_S_LEVER] = lever;
  c[SIM_S_KAPPA] = ray_slots::beam_variance(list.beam_divergence, list.divergence_variance);
  c[SIM_S_T_MIN] = list.range_min;
  c[SIM_S_T_MAX] = list.range_max;
}

}  // namespace

RayGrid make_ray_grid(const RayList& list, const RenderOptions& options) {
  validate(list, "sensor");
  RayGrid grid;
  grid.type = SensorType::kLidar;
  grid.rays = list.ray_count();
  const std::size_t width = ray_slots::set_rows_per_tile(grid, options);

  const double cut = widest_gap(list);
  std::vector<double> angles(grid.rays);
  for (std::size_t i = 0; i < grid.rays; ++i) {
    const double turned = list.azimuth[i] - cut;
    angles[i] = turned - kTurn * std::floor(turned / kTurn);
  }
  std::vector<std::size_t> order(grid.rays);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return list.elevation[a] > list.elevation[b];
  });
  const Packing packing = best_packing(list, angles, order, grid.frame.rows_per_tile, width);
  if (packing.rows() > kMostRows) {
    throw_input_error("ray list " + list.name,
                      "azimuths",
                      fmt::format("{} rows of {} rays in a tile", packing.rows(), width),
                      fmt::format("at most {} rows: rays spread along the azimuth", kMostRows));
  }
  auto& frame = grid.frame;
  frame.rows = static_cast<std::uint32_t>(packing.rows());
  frame.tiles_x = static_cast<std::uint32_t>(packing.columns);
  frame.tiles_y = (frame.rows + frame.rows_per_tile - 1) / frame.rows_per_tile;
  ray_slots::allocate(grid);

  std::vector<double> lowest, highest;
  std::vector<std::size_t> used(packing.columns);
  for (std::size_t row = 0; row < packing.rows(); ++row) {
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(packing.row_starts[row]);
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(packing.row_starts[row + 1]);
    highest.push_back(list.elevation[*begin] + kElevationSlack_rad);
    lowest.push_back(list.elevation[*(end - 1)] - kElevationSlack_rad);
    std::stable_sort(begin, end, [&](std::size_t a, std::size_t b) { return angles[a] < angles[b]; });
    std::fill(used.begin(), used.end(), std::size_t{0});
    for (auto ray = begin; ray != end; ++ray) {
      const std::size_t column = packing.column(angles[*ray]);
      const std::size_t tile = row / frame.rows_per_tile * packing.columns + column;
      const std::size_t slot = tile * SIM_TILE_RAYS + row % frame.rows_per_tile * width + used[column]++;
      ray_slots::set_ray(
          grid, slot, *ray, list.direction(*ray), list.ray_origin(*ray), list.time_fraction[*ray]);
      grid.u[slot] = static_cast<float>(angles[*ray]);
    }
  }
  ray_slots::fill_elevation_table(grid, lowest, highest);
  set_constants(grid, list, cut, packing);
  return grid;
}

}  // namespace simuli
