#include "host/render/rays/tile_choice.hpp"

#include <charconv>
#include <fmt/format.h>
#include <string_view>
#include <system_error>

#include "host/runtime/cache/disk_cache.hpp"

namespace simuli {
namespace {

std::string key_text(const Device& device, const TileChoiceKey& key) {
  const std::string sensor =
      fmt::format("lidar tiles 1\n{}\n{} rows\n{} rays\n", key.sensor, key.rows, key.rays);
  return program_key(device.info(), "", sensor);
}

}  // namespace

std::optional<TileChoice> stored_tiles(const Device& device, const TileChoiceKey& key) {
  const auto stored = load_binary(key_text(device, key));
  if (!stored) return std::nullopt;
  const std::string text(stored->begin(), stored->end());
  TileChoice tiles;
  const char* const end = text.data() + text.size();
  const auto elevation = std::from_chars(text.data(), end, tiles.elevation);
  if (elevation.ec != std::errc() || elevation.ptr == end) return std::nullopt;
  const auto rays = std::from_chars(elevation.ptr + 1, end, tiles.rays);
  if (rays.ec != std::errc() || rays.ptr != end || tiles.elevation < 1) return std::nullopt;
  return tiles;
}

void store_tiles(const Device& device, const TileChoiceKey& key, const TileChoice& tiles) {
  const std::string text = fmt::format("{} {}", tiles.elevation, tiles.rays);
  save_binary(key_text(device, key), {text.begin(), text.end()});
}

TileChoice resolved_tiles(const Device& device, const TileChoiceKey& key, TileChoice asked) {
  if (asked.elevation != 0 || asked.rays != 0) return asked;
  return stored_tiles(device, key).value_or(asked);
}

}  // namespace simuli
