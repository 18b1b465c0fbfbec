#pragma once
#include "host/device/render/device/buffer_table.hpp"
#include "host/device/render/rays/ray_grid.hpp"

namespace simuli {

template <>
struct ClTypeName<shared::FrameParams> {
  static constexpr std::string_view value = "FrameParams";
};

/// Sizes of a sensor's rays.
struct RaySizes {
  std::uint64_t slots = 0;  // S
  std::uint64_t tile_rows = 0;
  std::uint64_t rows = 0;          // LiDAR: sensor rows
  std::uint64_t lut_bins = 0;      // LiDAR: elevation bins
  std::uint64_t bins = 0;          // LiDAR: bins of columns
  std::uint64_t mask_corners = 0;  // LiDARs with culling: (mask rows + 1) x (mask columns + 1)
};

/// Layout of a sensor's rays in tiles, independent of the requested rays.
struct RayLayout : BufferTable<RaySizes> {
  using BufferTable::BufferTable;
  RayLayout(const Device& device, const RayGrid& grid, Precision precision);

  Reals u{*this, "ray_u", [](const RaySizes& s) { return s.slots; }};  // [S]
  Array<std::int32_t> row_lut{*this, "row_lut", [](const RaySizes& s) { return s.lut_bins; }};
  Reals row_elevation{*this, "row_elevation", [](const RaySizes& s) { return 2 * s.rows; }};  // [2][rows]
  Words tile_rows{*this, "tile_rows", [](const RaySizes& s) { return s.tile_rows + 1; }};
  Words tile_row_of_row{*this, "tile_row_of_row", [](const RaySizes& s) { return s.rows; }};
  Words column_of_bin{*this, "column_of_bin", [](const RaySizes& s) { return s.bins; }};
};

/// The rays requested by a frame.
struct RequestedRays : BufferTable<RaySizes> {
  using BufferTable::BufferTable;

  /// [7][S]; slots without a requested ray have a zero direction.
  Reals sensor_ray{*this, "sensor_ray", [](const RaySizes& s) { return 7 * s.slots; }};
  Words mask_row_of_row{*this, "mask_row_of_row", [](const RaySizes& s) { return s.rows; }};
  /// [mask rows + 1][mask columns + 1] occupied cells above and to the left.
  Words areas{*this, "areas", [](const RaySizes& s) { return s.mask_corners; }};
};

/// Both buffers, as kernel arguments.
struct RayBuffers {
  const RayLayout& layout;
  const RequestedRays& requested;
  void offer_to(Kernel& kernel) const {
    layout.offer_to(kernel);
    requested.offer_to(kernel);
  }
};

}  // namespace simuli
