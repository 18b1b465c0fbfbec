// Launcher of "kernels/color_grid.cl" and "kernels/color_grid_bwd.cl".
#include "host/base/error.hpp"
#include "host/render/frame/picture_stages.hpp"
#include "host/render/options/validate.hpp"

namespace simuli {
namespace {

constexpr std::size_t kVertex = 16;  // reals, as GRID_VERTEX
constexpr std::size_t kLocalSize = 32;

BuildOptions grid_options(const ColorGridBuffers& grids) {
  BuildOptions options;
  return options.real(grids.grid.precision())
      .define("GRID_X", grids.size_x)
      .define("GRID_Y", grids.size_y)
      .define("GRID_Z", grids.size_z);
}

std::uint32_t first_real(const ColorGridBuffers& grids, std::size_t index) {
  if ((index + 1) * grids.reals() > grids.grid.count()) {
    throw Error(ErrorKind::kInternal, "colour grid: there are fewer grids than that");
  }
  return static_cast<std::uint32_t>(index * grids.reals());
}

}  // namespace

ColorGridBuffers::ColorGridBuffers(const Device& device, const ColorGrids& grids, Precision precision)
    : size_x(grids.size_x),
      size_y(grids.size_y),
      size_z(grids.size_z),
      grid(device, "colour grids", precision) {
  if (size_x < 2 || size_y < 2 || size_z < 2) {
    throw Error(ErrorKind::kInternal, "colour grid: 2 x 2 x 2 vertices at least are needed");
  }
  need_numbers(grids.values, kLargestGain, "colour grid");
  std::vector<float> padded(grids.values.size() / ColorGrids::kMatrix * kVertex, 0.0F);
  for (std::size_t i = 0; i < grids.values.size(); ++i) {
    padded[i / ColorGrids::kMatrix * kVertex + i % ColorGrids::kMatrix] = grids.values[i];
  }
  grid.assign(padded);
}

void ColorGridBuffers::download(ColorGrids& grids) const {
  const std::vector<float> padded = grid.download_float();
  for (std::size_t i = 0; i < grids.values.size(); ++i) {
    grids.values[i] = padded[i / ColorGrids::kMatrix * kVertex + i % ColorGrids::kMatrix];
  }
}

std::uint32_t ColorGridBuffers::reals() const {
  return static_cast<std::uint32_t>(size_x * size_y * size_z) * std::uint32_t{kVertex};
}

ColorGridStage::ColorGridStage(const Device& device, const ColorGridBuffers& grids)
    : columns_(static_cast<std::size_t>(grids.size_x) - 1),
      vertices_(grids.reals() / kVertex),
      partial_reals_(columns_ * 2 * static_cast<std::size_t>(grids.size_z) * kVertex),
      partial_(device, "colour grid partial sums", grids.grid.precision()),
      forward_(Program(device, "kernels/color_grid.cl", grid_options(grids)), "color_grid"),
      rows_(Program(device, "kernels/color_grid_bwd.cl", grid_options(grids)), "color_grid_rows"),
      gather_(Program(device, "kernels/color_grid_bwd.cl", grid_options(grids)), "color_grid_gather") {}

void ColorGridStage::run(const shared::FrameParams& frame,
                         int width,
                         int height,
                         const ColorGridBuffers& grids,
                         std::size_t index,
                         const RealBuffer& out,
                         RealBuffer& picture) {
  picture.reserve(std::size_t{3} * frame.slots);
  forward_.launch(frame.slots,
                  kLocalSize,
                  frame,
                  static_cast<std::uint32_t>(width),
                  static_cast<std::uint32_t>(height),
                  first_real(grids, index),
                  grids.grid,
                  out,
                  picture);
}

void ColorGridStage::run_backward(const shared::FrameParams& frame,
                                  int width,
                                  int height,
                                  const ColorGridBuffers& grids,
                                  std::size_t index,
                                  const ColorGridScale& scale,
                                  FrameBuffers& b,
                                  RealBuffer& grads) {
  const auto rows = static_cast<std::size_t>(height);
  partial_.reserve(rows * partial_reals_);
  grads.reserve(grids.reals());
  const std::uint32_t first = first_real(grids, index);
  rows_.launch({columns_, rows},
               {1, 1},
               frame,
               static_cast<std::uint32_t>(width),
               static_cast<std::uint32_t>(height),
               first,
               grids.grid,
               b.out,
               b.grad_out,
               partial_);
  gather_.launch(round_up(vertices_, kLocalSize),
                 kLocalSize,
                 static_cast<std::uint32_t>(height),
                 first,
                 scale.variation,
                 scale.drift,
                 grids.grid,
                 partial_,
                 grads);
}

}  // namespace simuli
