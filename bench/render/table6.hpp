#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/render/lidar_frames.hpp"

namespace simuli::bench {

/// One request of tiles, what became of it, and how long a frame takes with it.
struct TileTime {
  LidarTiles tiles;
  std::uint32_t tile_rows = 0, tile_columns = 0;
  std::uint32_t tile_slots = 0;
  Spread frame_ms;
};

/// Frame times over the grid of elevation tiles and rays of a tile; requests that give the same tiles are
/// timed once.
struct TileGrid {
  std::vector<TileTime> times;
  std::size_t best = 0;
  TileTime automatic;  // what is rendered when nothing is asked for
};

/// Times every request briefly, then the fastest and the automatic one in turns, `frames` of each.
[[nodiscard]] TileGrid time_tiles(const Device& device,
                                  const LidarModel& sensor,
                                  std::int64_t particles,
                                  int frames);

/// Table 6 of the paper: how long a frame takes by elevation tiles and rays per tile.
///   table6/<sensor>_<n>k/<elevation tiles>x<rays>[_chosen]     ms per frame; chosen: the fastest of the grid
///   table6/<sensor>_<n>k/automatic                             ms, of what nothing asked for gives
///   table6/<sensor>_<n>k/slowest_over_chosen                   ratio
[[nodiscard]] std::vector<Row> run_table6(const std::string& device_request,
                                          std::int64_t particles,
                                          const Progress& note);

/// Millions of rays per second for 64 x 2650, 128 x 3600 and 16 x 1800 rays and 50 k, 200 k and 1 M
/// particles: in tiles of 8 beams without culling, and as rendered by default, frames of both in turns.
///   lidar_rate/<sensor>_<n>k/<before|after>, .../ratio
[[nodiscard]] std::vector<Row> run_lidar_rates(const std::string& device_request, const Progress& note);

}  // namespace simuli::bench
