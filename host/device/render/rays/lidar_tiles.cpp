// Procedure 1: combines its device steps (lidar_tiling.cpp) for rows of rays and for ray lists.
#include "host/device/render/rays/lidar_tiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/device/render/rays/lidar_tiling.hpp"

namespace simuli {
namespace {

// The paper's 400 bins merge neighbouring beams of dense sensors; 4096 separate them.
constexpr std::uint32_t kBins = 4096;
// Ray blocks of a tile, one per beam (docs/DECISIONS.md, "Tiles").
constexpr std::uint32_t kMostRows = 16;
constexpr std::uint32_t kMostRays = SIM_TILE_RAYS;
// In wider tiles the two positions of a particle at the cut would be indistinguishable.
constexpr std::uint32_t kFewestColumns = 8;

using Uints = Buffer<std::uint32_t>;

/// Bins over all values, slightly more so that the highest is included.
TileBins bins_over(const std::vector<float>& values, std::uint32_t count) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double span = static_cast<double>(*high) - static_cast<double>(*low) + 1e-6;
  return {*low, static_cast<float>(count / span), count};
}

std::uint32_t divided_up(std::size_t a, std::size_t b) { return static_cast<std::uint32_t>((a + b - 1) / b); }

}  // namespace

double LidarTiles::column_begin(std::size_t c) const {
  const auto bin = std::lower_bound(column_of_bin.begin(), column_of_bin.end(), c) - column_of_bin.begin();
  return static_cast<double>(first) + static_cast<double>(bin) / static_cast<double>(scale);
}

LidarTiles tile_rows_of_rays(const Device& device,
                             const std::string& sensor,
                             const std::vector<float>& row_elevation,
                             const std::vector<float>& x) {
  const auto rows = static_cast<std::uint32_t>(row_elevation.size());
  const auto row_rays = static_cast<std::uint32_t>(x.size() / rows);
  LidarTilingStage tiler(device);
  LidarTiles out;

  const Buffer<float> elevation(device, "row elevations", row_elevation);
  const TileBins bins = bins_over(row_elevation, kBins);
  std::uint32_t groups = 0;
  const Uints group_of_bin =
      tiler.groups_of(elevation, row_rays, bins, divided_up(rows, kMostRows), kBins, groups);
  const std::uint32_t group_rays = tiler.fullest_group(elevation, row_rays, bins, group_of_bin, groups);
  const Uints group_of_row = tiler.groups_of_rows(elevation, bins, group_of_bin);
  const std::uint32_t tile_rows = tiler.cut(group_of_row, rows, kMostRows, out);

  out.row_slots = kMostRays / SIM_RAY_BLOCK / tile_rows;
  const std::uint32_t width = out.row_slots * SIM_RAY_BLOCK;  // upper bound of one row's slots in one tile

  const Buffer<float> places(device, "ray places", x);
  const Uints order(device, "rays by row", LidarTilingStage::iota(rows * row_rays));
  std::vector<std::uint32_t> starts(std::size_t{rows} + 1);
  for (std::uint32_t row = 0; row <= rows; ++row) starts[row] = row * row_rays;
  const Uints row_starts(device, "row starts", starts);
  // N_theta = H_max / M rounded up, with H_max of the fullest elevation tile after cutting; jitter of measured
  // rays needs a few more.
  const std::uint32_t tile_rays = std::min(group_rays, tile_rows * row_rays);
  out.columns = std::max({kFewestColumns, divided_up(tile_rays, kMostRays), divided_up(row_rays, width)});
  const std::uint32_t most_columns = std::min(4 * out.columns + 64, LidarTiles::kMostColumns);
  for (; out.columns <= most_columns; ++out.columns) {
    const TileBins columns = bins_over(x, out.columns);
    const Uints column_of_bin(device, "columns of bins", LidarTilingStage::iota(out.columns));
    const auto fullest = tiler.place(places, order, row_starts, columns, column_of_bin, out);
    if (fullest.row > width || fullest.tile > kMostRays) continue;
    out.first = columns.first;
    out.scale = columns.scale;
    out.column_of_bin = LidarTilingStage::iota(out.columns);
    out.slot_of_ray = tiler.slot_of_ray();
    return out;
  }
  throw_input_error("lidar " + sensor,
                    "ray azimuths",
                    fmt::format("more than {} rays of one beam, or {} of a tile, in 1/{} of the sweep",
                                width,
                                kMostRays,
                                most_columns),
                    "rays spread along the sweep");
}

LidarTiles tile_ray_list(const Device& device,
                         const std::string& sensor,
                         const std::vector<float>& elevation,
                         const std::vector<float>& x) {
  LidarTilingStage tiler(device);
  const Buffer<float> elevations(device, "ray elevations", elevation), places(device, "ray places", x);
  const TileBins bins = bins_over(elevation, kBins);
  ListRows rows(device);

  // Chooses the number with the fewest slots among those that make tiles about square.
  const auto extent = [](const std::vector<float>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return std::max(static_cast<double>(*high) - static_cast<double>(*low), 1e-3);
  };
  const double tiles = static_cast<double>(x.size()) / kMostRays;
  const double square = std::sqrt(tiles * extent(elevation) / extent(x));
  std::vector<std::uint32_t> numbers;
  for (const double factor : {0.5, 0.7, 1.0, 1.4, 2.0}) {
    const auto number = static_cast<std::uint32_t>(std::clamp(square * factor, 1.0, 4096.0));
    if (numbers.empty() || numbers.back() != number) numbers.push_back(number);
  }
  LidarTiles best;
  for (const std::uint32_t number : numbers) {
    LidarTiles out;
    std::uint32_t groups = 0;
    const Uints group_of_bin = tiler.groups_of(elevations, 1, bins, number, kBins, groups);
    const std::uint32_t group_rays = tiler.fullest_group(elevations, 1, bins, group_of_bin, groups);
    // Splits columns that are too wide to separate two positions: at most kFewestColumns more.
    const std::uint32_t columns = std::clamp(
        divided_up(group_rays, kMostRays), kFewestColumns, LidarTiles::kMostColumns - kFewestColumns);
    const TileBins x_bins = bins_over(x, std::max(kBins, 4 * columns));
    const auto widest = static_cast<std::uint32_t>(
        std::min(kTurn / kFewestColumns * static_cast<double>(x_bins.scale), double{LidarTiles::kMostRows}));
    const Uints column_of_bin =
        tiler.groups_of(places, 1, x_bins, columns, std::max(widest, 1U), out.columns);
    if (!tiler.list_rows(
            {elevations, bins}, group_of_bin, {places, x_bins}, column_of_bin, out.columns, rows)) {
      continue;
    }
    static_cast<void>(
        tiler.cut(rows.group_of_row, static_cast<std::uint32_t>(rows.group_of_row.count()), kMostRows, out));
    if (!best.tile_rows.empty() && out.tiles() >= best.tiles()) continue;
    out.row_slots = 1;
    static_cast<void>(tiler.place(places, rows.order, rows.starts, x_bins, column_of_bin, out));
    out.first = x_bins.first;
    out.scale = x_bins.scale;
    out.column_of_bin = column_of_bin.download();
    out.slot_of_ray = tiler.slot_of_ray();
    out.order = rows.order.download();
    out.row_starts = rows.starts.download();
    best = std::move(out);
  }
  if (best.tile_rows.empty()) {
    throw_input_error("ray list " + sensor,
                      "azimuths",
                      fmt::format("rays that need more than {} rows", std::uint32_t{LidarTiles::kMostRows}),
                      "rays spread along the azimuth");
  }
  return best;
}

}  // namespace simuli
