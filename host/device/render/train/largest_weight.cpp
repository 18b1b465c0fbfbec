// Launcher of "kernels/largest_weight.cl".
#include "host/device/render/train/largest_weight.hpp"

namespace simuli {

LargestWeightStage::LargestWeightStage(const Device& device, const Variant& variant)
    : work_items_(static_cast<std::size_t>(variant.options.shape.work_items)),
      largest_weight_(Program(device, "kernels/largest_weight.cl", variant.build_options()),
                      "largest_weight") {}

void LargestWeightStage::run(const shared::FrameParams& frame,
                             const RayBuffers& rays,
                             const FrameBuffers& made,
                             Buffer<std::uint32_t>& largest) {
  largest_weight_.run(
      std::size_t{frame.tiles_x} * frame.tiles_y * work_items_,
      work_items_,
      {{"frame", frame}, made.constants, made.rays, rays, made.binned, made.projected, {"largest", largest}});
}

}  // namespace simuli
