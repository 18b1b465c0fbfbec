// Launcher of "kernels/color_grid_bwd.cl".
#include "host/device/render/backward/backward_stages.hpp"

namespace simuli {
namespace {

int levels_of_item(const Device& device, const ColorGridBuffers& grids) {
  return device.info().is_cpu ? grids.size_z : 1;
}

Program program(const Device& device, const ColorGridBuffers& grids) {
  return {device,
          "kernels/color_grid_bwd.cl",
          grids.options().define("GRID_LEVELS", levels_of_item(device, grids))};
}

}  // namespace

ColorGridBackwardStage::ColorGridBackwardStage(const Device& device, const ColorGridBuffers& grids)
    : columns_(static_cast<std::size_t>(grids.size_x) - 1),
      row_items_(columns_ * static_cast<std::size_t>(grids.size_z / levels_of_item(device, grids))),
      vertices_(grids.reals() / ColorGridBuffers::kVertexReals),
      partial_reals_(columns_ * 2 * static_cast<std::size_t>(grids.size_z) * ColorGridBuffers::kVertexReals),
      scratch_(device, grids.precision()),
      rows_(program(device, grids), "color_grid_rows"),
      pixels_(program(device, grids), "color_grid_pixels"),
      gather_(program(device, grids), "color_grid_gather") {}

void ColorGridBackwardStage::run(const shared::FrameParams& frame,
                                 int width,
                                 int height,
                                 const ColorGridBuffers& grids,
                                 std::size_t index,
                                 const ColorGridScale& scale,
                                 const Blended& blended,
                                 GradientBuffers& gradients,
                                 RealBuffer& grads) {
  const auto rows = static_cast<std::size_t>(height);
  scratch_.reserve({rows, partial_reals_});
  grads.reserve(grids.reals());
  const std::uint32_t first = grids.first_real(index);
  const auto pixels_x = static_cast<std::uint32_t>(width), pixels_y = static_cast<std::uint32_t>(height);
  rows_.run_over(row_items_ * rows,
                 {{"frame", frame},
                  {"width", pixels_x},
                  {"height", pixels_y},
                  blended,
                  {"grad_out", gradients.grad_out},
                  {"partial", scratch_.partial}});
  pixels_.run_over(static_cast<std::size_t>(width) * rows,
                   {{"frame", frame},
                    {"width", pixels_x},
                    {"height", pixels_y},
                    {"first", first},
                    grids,
                    blended,
                    {"grad_out", gradients.grad_out}});
  gather_.run_over(vertices_,
                   {{"height", pixels_y},
                    {"first", first},
                    {"tv_scale", scale.variation},
                    {"drift_scale", scale.drift},
                    {"all_grids", grids.grid},
                    {"partial", scratch_.partial},
                    {"grads", grads}});
}

}  // namespace simuli
