#pragma once
// What is fastest on a device, found by rendering: tiles of a LiDAR, and how work is spread over work-items.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/base/spread.hpp"
#include "host/render/options/options.hpp"
#include "host/runtime/cache/tuning.hpp"
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

/// A camera's and a LiDAR's frame in one way of launching.
struct TuningTime {
  DeviceTuning tuning;
  Spread camera_ms, lidar_ms;
};

/// Every way that was tried, the usual one (0 throughout) first, and the one to keep: another than the usual
/// one only where the two frames take at least 2 % less time, in their geometric mean, and less by more than
/// what both times vary by.
struct TuningSearch {
  std::vector<TuningTime> times;
  std::size_t best = 0;
};

/// Times shapes of a tile, then sizes of groups with the best of them, each `frames` times in turns with the
/// others: 640 x 360 pixels and 64 x 2650 beams before that street. The device is used as before afterwards.
[[nodiscard]] TuningSearch time_tunings(const Device& device, std::int64_t particles, int frames);

}  // namespace simuli
