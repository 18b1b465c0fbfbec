#pragma once
// Which tiles a LiDAR is rendered with when nobody asks for particular ones: what `simuli tile --tune` found
// fastest on this device, kept beside the compiled programs (host/runtime/cache/disk_cache.hpp).
#include <optional>
#include <string>

#include "host/render/options/options.hpp"

namespace simuli {

class Device;

/// What a choice belongs to: a sensor by name and size, in tiles of this device's shape.
struct TileChoiceKey {
  std::string sensor;
  std::size_t rows = 0;  // 0: a ray list
  std::size_t rays = 0;
};

/// Nothing when none is stored for this sensor, device and driver.
[[nodiscard]] std::optional<TileChoice> stored_tiles(const Device& device, const TileChoiceKey& key);
/// Replaces what was stored. A cache that can't be written is no error.
void store_tiles(const Device& device, const TileChoiceKey& key, const TileChoice& tiles);

/// `asked`, with what it leaves open filled in from the stored choice; nothing stored: as it is.
[[nodiscard]] TileChoice resolved_tiles(const Device& device, const TileChoiceKey& key, TileChoice asked);

}  // namespace simuli
