#pragma once
// Device buffers for processing a camera's picture after blending (METHOD sections 9 and 10).
#include <cstdint>

#include "host/core/scene/appearance.hpp"
#include "host/device/render/device/buffer_table.hpp"

namespace simuli {

/// An environment map on the device.
struct EnvironmentSizes {
  std::uint64_t texels = 0;
};
struct EnvironmentBuffers : BufferTable<EnvironmentSizes> {
  using BufferTable::BufferTable;  // empty
  EnvironmentBuffers(const Device& device, const EnvironmentMap& map, Precision precision);
  [[nodiscard]] EnvironmentMap download() const;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  /// [height][width][4]
  Reals texture{*this, "texture", [](const EnvironmentSizes& s) { return 4 * s.texels; }};
};

/// Bilateral grids on the device, consecutive.
struct ColorGridSizes {
  std::uint64_t grids = 0;
  std::uint64_t vertices = 0;  // vertices per grid
};
struct ColorGridBuffers : BufferTable<ColorGridSizes> {
  using BufferTable::BufferTable;  // empty
  ColorGridBuffers(const Device& device, const ColorGrids& grids, Precision precision);
  /// Copies the values to `grids` of the same sizes.
  void download(ColorGrids& grids) const;
  /// Reals of one grid: [size_y][size_x][size_z][16].
  [[nodiscard]] std::uint32_t reals() const;
  /// Index of the first real of grid `index`. Throws Error{kInternal} beyond the last grid.
  [[nodiscard]] std::uint32_t first_real(std::size_t index) const;
  /// Returns the definitions for kernels of grids of these sizes.
  [[nodiscard]] BuildOptions options() const;
  static constexpr std::uint64_t kVertexReals = 16;  // as GRID_VERTEX
  int size_x = 0;
  int size_y = 0;
  int size_z = 0;
  /// [grids][reals]
  Reals grid{*this, "grid", [](const ColorGridSizes& s) { return kVertexReals * s.grids * s.vertices; }};
};

}  // namespace simuli
