// Launcher of "kernels/render.cl" and "kernels/render_bwd.cl".
#include "host/render/stages.hpp"

namespace simuli {

RenderStage::RenderStage(const Device& device, const Variant& variant)
    : work_items_(static_cast<std::size_t>(variant.shape.work_items)),
      render_(Program(device, "kernels/render.cl", variant.options()), "render"),
      render_bwd_(Program(device, "kernels/render_bwd.cl", variant.options()), "render_bwd") {}

void RenderStage::run(const shared::FrameParams& frame, const RayBuffers& rays, FrameBuffers& b) {
  b.out.reserve(std::size_t{SIM_OUTPUTS} * frame.slots);
  render_.launch(std::size_t{frame.tiles_x} * frame.tiles_y * work_items_,
                 work_items_,
                 frame,
                 b.sensor,
                 b.world_ray,
                 rays.u,
                 b.first,
                 b.payload,
                 b.records,
                 b.out);
}

void RenderStage::run_backward(const shared::FrameParams& frame, const RayBuffers& rays, FrameBuffers& b) {
  b.grads.reserve(std::size_t{b.instances} * SIM_GRAD);
  render_bwd_.launch(std::size_t{frame.tiles_x} * frame.tiles_y * work_items_,
                     work_items_,
                     frame,
                     b.sensor,
                     b.world_ray,
                     rays.u,
                     b.first,
                     b.payload,
                     b.records,
                     b.footprints,
                     b.emission,
                     b.out,
                     b.grad_out,
                     b.grads);
}

}  // namespace simuli
