#pragma once
// Procedure 1 of the paper (docs/METHOD.md section 5): a LiDAR's rays in tiles of few rays each.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cl/shared/layout.h"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Tiles of a LiDAR: tile rows of whole sensor rows x tile columns. A tile's slots are its rows' slots, each
/// row_slots x 16 of them.
struct LidarTiles {
  static constexpr std::uint32_t kMostRows = 0xffff;  // footprints name rows in 16 bits
  static constexpr std::uint32_t kMostColumns = SIM_MOST_TILE_COLUMNS;
  std::uint32_t columns = 0;                   // of tiles
  std::uint32_t row_slots = 0;                 // slot rows of one sensor row in one tile
  std::vector<std::uint32_t> tile_rows;        // [tile rows + 1] first sensor row of each
  std::vector<std::uint32_t> tile_row_of_row;  // [rows]
  float first = 0.0F;                          // rad, where the first tile starts
  float scale = 0.0F;                          // bins per rad
  std::vector<std::uint32_t> column_of_bin;    // [bins] of x; the bins of a spinning sensor are its columns
  std::vector<std::uint32_t> slot_of_ray;      // [rays]
  // Of a ray list, whose rows are made here: rays by row, the rows from top to bottom.
  std::vector<std::uint32_t> order;       // [rays]
  std::vector<std::uint32_t> row_starts;  // [rows + 1] into `order`

  [[nodiscard]] std::size_t rows() const { return tile_row_of_row.size(); }
  [[nodiscard]] std::size_t tiles() const { return (tile_rows.size() - 1) * columns; }
  /// rad, where tile column c begins; c = columns: where the last one ends.
  [[nodiscard]] double column_begin(std::size_t c) const;
};

/// Rows of equally many rays, all of one elevation: row_elevation[rows] rad, never rising. x[rows][row_rays]
/// rad is the place along the spin. A tile has about 16 rows; tile columns are uniform, as few as no tile
/// needs to hold more than SIM_TILE_RAYS rays. Error{kInput} naming `sensor` for rays too uneven for that.
[[nodiscard]] LidarTiles tile_rows_of_rays(const Device& device,
                                           const std::string& sensor,
                                           const std::vector<float>& row_elevation,
                                           const std::vector<float>& x);

/// Rays without rows: the same along both axes, and rows cut from the elevation tiles. elevation, x: [rays].
[[nodiscard]] LidarTiles tile_ray_list(const Device& device,
                                       const std::string& sensor,
                                       const std::vector<float>& elevation,
                                       const std::vector<float>& x);

}  // namespace simuli
