#pragma once
// Procedure 1 of the paper (docs/METHOD.md section 5): groups a LiDAR's rays into tiles of few rays.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cl/shared/layout.h"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Tiles of a LiDAR: tile rows of whole sensor rows x tile columns. A tile has the slots of its rows, row_slots
/// x 16 each.
struct LidarTiles {
  static constexpr std::uint32_t kMostRows = 0xffff;  // footprints store rows in 16 bits
  static constexpr std::uint32_t kMostColumns = SIM_MOST_TILE_COLUMNS;
  std::uint32_t columns = 0;  // tile columns
  std::uint32_t row_slots = 0;  // ray blocks of one sensor row in one tile
  std::vector<std::uint32_t> tile_rows;        // [tile rows + 1] first sensor row of each
  std::vector<std::uint32_t> tile_row_of_row;  // [rows]
  float first = 0.0F;  // rad, start of the first tile
  float scale = 0.0F;                          // bins per rad
  std::vector<std::uint32_t> column_of_bin;  // [bins] of x to tile columns
  std::vector<std::uint32_t> slot_of_ray;      // [rays]
  // Ray lists, whose rows are made here: rays by row, rows from top to bottom.
  std::vector<std::uint32_t> order;       // [rays]
  std::vector<std::uint32_t> row_starts;  // [rows + 1] into `order`

  [[nodiscard]] std::size_t rows() const { return tile_row_of_row.size(); }
  [[nodiscard]] std::size_t tiles() const { return (tile_rows.size() - 1) * columns; }
  /// Start of tile column c in rad; c = columns: end of the last.
  [[nodiscard]] double column_begin(std::size_t c) const;
};

/// Tiles rows with equal numbers of rays, each at one elevation: row_elevation[rows] rad, descending.
/// x[rows][row_rays] rad is the position along the spin. A tile has about 16 rows; tile columns are uniform, as
/// few as possible with at most SIM_TILE_RAYS rays per tile. Throws Error{kInput} with `sensor` for rays that
/// are too uneven.
[[nodiscard]] LidarTiles tile_rows_of_rays(const Device& device,
                                           const std::string& sensor,
                                           const std::vector<float>& row_elevation,
                                           const std::vector<float>& x);

/// Tiles rays without rows: equal counts along both axes, and rows cut from the elevation tiles. elevation, x:
/// [rays].
[[nodiscard]] LidarTiles tile_ray_list(const Device& device,
                                       const std::string& sensor,
                                       const std::vector<float>& elevation,
                                       const std::vector<float>& x);

}  // namespace simuli
