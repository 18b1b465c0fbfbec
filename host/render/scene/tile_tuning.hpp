#pragma once
// Which tiles of a LiDAR are fastest on a device, found by rendering with each of them.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/base/spread.hpp"
#include "host/render/options/options.hpp"
#include "host/runtime/device.hpp"
#include "host/sensors/lidar_model.hpp"

namespace simuli {

/// One request of tiles, what became of it, and how long a frame takes with it.
struct TileTime {
  TileChoice tiles;
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

/// Times every request briefly, then the fastest and the automatic one in turns, `frames` of each: before
/// `particles` Gaussians of the street of host/scene/particle_street.hpp, SH degree 3.
[[nodiscard]] TileGrid time_tiles(const Device& device,
                                  const LidarModel& sensor,
                                  std::int64_t particles,
                                  int frames);

}  // namespace simuli
