// Launcher of "kernels/color_grid_bwd.cl".
#include "host/render/backward/backward_stages.hpp"

namespace simuli {
namespace {

Program program(const Device& device, const ColorGridBuffers& grids) {
  return {device, "kernels/color_grid_bwd.cl", grids.options()};
}

}  // namespace

ColorGridBackwardStage::ColorGridBackwardStage(const Device& device, const ColorGridBuffers& grids)
    : columns_(static_cast<std::size_t>(grids.size_x) - 1),
      vertices_(grids.reals() / ColorGridBuffers::kVertexReals),
      partial_reals_(columns_ * 2 * static_cast<std::size_t>(grids.size_z) * ColorGridBuffers::kVertexReals),
      scratch_(device, grids.precision()),
      rows_(program(device, grids), "color_grid_rows"),
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
  rows_.run({columns_, rows},
            {1, 1},
            {{"frame", frame},
             {"width", static_cast<std::uint32_t>(width)},
             {"height", static_cast<std::uint32_t>(height)},
             {"first", first},
             grids,
             blended,
             {"grad_out", gradients.grad_out},
             {"partial", scratch_.partial}});
  gather_.run_over(vertices_,
                   {{"height", static_cast<std::uint32_t>(height)},
                    {"first", first},
                    {"tv_scale", scale.variation},
                    {"drift_scale", scale.drift},
                    {"all_grids", grids.grid},
                    {"partial", scratch_.partial},
                    {"grads", grads}});
}

}  // namespace simuli
