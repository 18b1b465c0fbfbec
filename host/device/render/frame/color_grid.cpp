// Launcher of "kernels/color_grid.cl".
#include "host/device/render/frame/stages.hpp"

namespace simuli {
ColorGridStage::ColorGridStage(const Device& device, const ColorGridBuffers& grids)
    : color_grid_(Program(device, "kernels/color_grid.cl", grids.options()), "color_grid") {}

void ColorGridStage::run(const shared::FrameParams& frame,
                         int width,
                         int height,
                         const ColorGridBuffers& grids,
                         std::size_t index,
                         const Blended& blended,
                         RealBuffer& picture) {
  picture.reserve(std::size_t{3} * frame.slots);
  color_grid_.run_over(frame.slots,
                       {{"frame", frame},
                        {"width", static_cast<std::uint32_t>(width)},
                        {"height", static_cast<std::uint32_t>(height)},
                        {"first", grids.first_real(index)},
                        grids,
                        blended,
                        {"picture", picture}});
}

}  // namespace simuli
