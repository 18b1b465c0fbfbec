// Launcher of "kernels/render.cl" and "kernels/render_per_ray.cl".
#include "host/render/frame/stages.hpp"

namespace simuli {

namespace {

BuildOptions forward_options(const Variant& variant) {
  BuildOptions options = variant.tile_options();
  if (variant.sh_direction == ShDirection::kRay) {
    options.define("RAY_SH", true).define("CLAMPED_CHANNELS", variant.sensor == SensorType::kCamera ? 3 : 1);
  }
  return options;
}

}  // namespace

RenderStage::RenderStage(const Device& device, const Variant& variant)
    : work_items_(static_cast<std::size_t>(variant.shape.work_items)),
      render_(Program(device,
                      variant.order == Order::kPerRay ? "kernels/render_per_ray.cl" : "kernels/render.cl",
                      forward_options(variant)),
              "render") {}

void RenderStage::run(const shared::FrameParams& frame,
                      const ParticleBuffers& particles,
                      const RayBuffers& rays,
                      const FrameConstants& constants,
                      const WorldRays& world_rays,
                      const Projected& projected,
                      const Binned& binned,
                      Blended& out) {
  out.reserve({.slots = frame.slots});
  render_.run(std::size_t{frame.tiles_x} * frame.tiles_y * work_items_,
              work_items_,
              {{"frame", frame}, constants, world_rays, rays, binned, projected, particles, out});
}

}  // namespace simuli
