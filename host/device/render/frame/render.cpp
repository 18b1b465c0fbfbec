// Launcher of "kernels/render.cl", "kernels/render_window.cl" and "kernels/render_per_ray.cl".
#include "host/device/render/frame/stages.hpp"

namespace simuli {

RenderStage::RenderStage(const Device& device, const Variant& variant)
    : work_items_(static_cast<std::size_t>(variant.options.shape.work_items)),
      outputs_(variant.frame.sensor == SensorType::kLidar ? SIM_OUTPUTS : SIM_O_DROP),
      render_(variant.options.order == Order::kRange
                  ? Kernel(Program(device, "kernels/render.cl", variant.build_options()), "render")
                  : Kernel(Program(device, "kernels/render_window.cl", variant.build_options()),
                           "render_window")) {
  if (variant.options.order == Order::kPerRay) {
    per_ray_.emplace(Program(device, "kernels/render_per_ray.cl", variant.build_options()), "render_per_ray");
  }
}

void RenderStage::run(const shared::FrameParams& frame,
                      const ParticleBuffers& particles,
                      const RayBuffers& rays,
                      const FrameConstants& constants,
                      const WorldRays& world_rays,
                      const Projected& projected,
                      const Binned& binned,
                      Blended& out) {
  const std::size_t items = std::size_t{frame.tiles_x} * frame.tiles_y * work_items_;
  out.reserve({.slots = frame.slots, .outputs = outputs_, .work_items = per_ray_ ? items : 0});
  const auto launch = [&](Kernel& kernel) {
    kernel.run(items,
               work_items_,
               {{"frame", frame}, constants, world_rays, rays, binned, projected, particles, out});
  };
  launch(render_);
  if (per_ray_) launch(*per_ray_);
}

}  // namespace simuli
