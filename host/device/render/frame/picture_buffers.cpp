#include "host/device/render/frame/picture_buffers.hpp"

#include "host/core/base/error.hpp"
#include "host/device/render/options/validate.hpp"

namespace simuli {

EnvironmentBuffers::EnvironmentBuffers(const Device& device, const EnvironmentMap& map, Precision precision)
    : BufferTable(device, precision),
      width(static_cast<std::uint32_t>(map.width)),
      height(static_cast<std::uint32_t>(map.height)) {
  const std::size_t texels = std::size_t{width} * height;
  if (width < 2 || height < 2 || map.texels.size() != 3 * texels) {
    throw Error(ErrorKind::kInternal, "environment: 2 x 2 texels of 3 values at least are needed");
  }
  need_numbers(map.texels, kLargestColor, "environment map");
  std::vector<float> padded(4 * texels, 0.0F);
  for (std::size_t i = 0; i < texels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) padded[4 * i + c] = map.texels[3 * i + c];
  }
  texture.assign(padded);
}

EnvironmentMap EnvironmentBuffers::download() const {
  EnvironmentMap map{static_cast<int>(width), static_cast<int>(height), {}};
  const std::vector<float> padded = texture.download_float();
  map.texels.reserve(padded.size() / 4 * 3);
  for (std::size_t i = 0; i < padded.size(); ++i) {
    if (i % 4 < 3) map.texels.push_back(padded[i]);
  }
  return map;
}

ColorGridBuffers::ColorGridBuffers(const Device& device, const ColorGrids& grids, Precision precision)
    : BufferTable(device, precision), size_x(grids.size_x), size_y(grids.size_y), size_z(grids.size_z) {
  if (size_x < 2 || size_y < 2 || size_z < 2) {
    throw Error(ErrorKind::kInternal, "colour grid: 2 x 2 x 2 vertices at least are needed");
  }
  need_numbers(grids.values, kLargestGain, "colour grid");
  std::vector<float> padded(grids.values.size() / ColorGrids::kMatrix * kVertexReals, 0.0F);
  for (std::size_t i = 0; i < grids.values.size(); ++i) {
    padded[i / ColorGrids::kMatrix * kVertexReals + i % ColorGrids::kMatrix] = grids.values[i];
  }
  grid.assign(padded);
}

void ColorGridBuffers::download(ColorGrids& grids) const {
  const std::vector<float> padded = grid.download_float();
  for (std::size_t i = 0; i < grids.values.size(); ++i) {
    grids.values[i] = padded[i / ColorGrids::kMatrix * kVertexReals + i % ColorGrids::kMatrix];
  }
}

std::uint32_t ColorGridBuffers::reals() const {
  return static_cast<std::uint32_t>(size_x * size_y * size_z) * static_cast<std::uint32_t>(kVertexReals);
}

std::uint32_t ColorGridBuffers::first_real(std::size_t index) const {
  if ((index + 1) * reals() > grid.count()) {
    throw Error(ErrorKind::kInternal, "colour grid: there are fewer grids than that");
  }
  return static_cast<std::uint32_t>(index * reals());
}

BuildOptions ColorGridBuffers::options() const {
  return BuildOptions()
      .real(precision())
      .define("GRID_X", size_x)
      .define("GRID_Y", size_y)
      .define("GRID_Z", size_z);
}

}  // namespace simuli
