#pragma once
// How a LiDAR's rays fall into tiles, as a picture.
#include <cstdint>
#include <string>
#include <vector>

#include "host/render/rays/ray_grid.hpp"
#include "io/picture/image.hpp"

namespace simuli::cli {

/// Rays of each tile, row-major from the top left.
[[nodiscard]] std::vector<std::uint32_t> rays_of_tiles(const RayGrid& grid);

/// Three panels over spin angle and elevation: the beam pattern, the tiles' boundaries over it, both of a
/// part of the sweep that shows single rays, and the rays per tile of the whole sensor.
[[nodiscard]] Image tile_picture(const RayGrid& grid, const std::string& title);

}  // namespace simuli::cli
