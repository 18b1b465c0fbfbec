// Launcher of "kernels/render.cl" and "kernels/render_per_ray.cl".
#include "host/render/frame/stages.hpp"

namespace simuli {

RenderStage::RenderStage(const Device& device, const Variant& variant)
    : work_items_(static_cast<std::size_t>(variant.frame.shape.work_items)),
      outputs_(variant.frame.sensor == SensorType::kLidar ? SIM_OUTPUTS : SIM_O_DROP),
      render_(
          Program(device,
                  variant.options.order == Order::kPerRay ? "kernels/render_per_ray.cl" : "kernels/render.cl",
                  variant.build_options()),
          "render") {}

void RenderStage::run(const shared::FrameParams& frame,
                      const ParticleBuffers& particles,
                      const RayBuffers& rays,
                      const FrameConstants& constants,
                      const WorldRays& world_rays,
                      const Projected& projected,
                      const Binned& binned,
                      Blended& out) {
  out.reserve({.slots = frame.slots, .outputs = outputs_});
  render_.run(std::size_t{frame.tiles_x} * frame.tiles_y * work_items_,
              work_items_,
              {{"frame", frame}, constants, world_rays, rays, binned, projected, particles, out});
}

}  // namespace simuli
