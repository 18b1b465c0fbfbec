// Launcher of "kernels/render.cl", "kernels/render_per_ray.cl" and "kernels/render_bwd.cl".
#include "host/render/frame/stages.hpp"

namespace simuli {

namespace {

BuildOptions tile_options(const Variant& variant) {
  BuildOptions options = variant.options();
  return options.define("NR", variant.shape.vectors).define("LS", variant.shape.work_items);
}

BuildOptions forward_options(const Variant& variant) {
  BuildOptions options = tile_options(variant);
  if (variant.sh_direction == ShDirection::kRay) {
    options.define("RAY_SH", true).define("CLAMPED_CHANNELS", variant.sensor == SensorType::kCamera ? 3 : 1);
  }
  return options;
}

}  // namespace

RenderStage::RenderStage(const Device& device, const Variant& variant)
    : device_(device),
      variant_(variant),
      render_(Program(device,
                      variant.order == Order::kPerRay ? "kernels/render_per_ray.cl" : "kernels/render.cl",
                      forward_options(variant)),
              "render") {}

RenderStage::Backward& RenderStage::backward(const BackwardExtras& extras) {
  std::optional<Backward>& kernel = backward_[extras.errors ? 1 : 0][extras.ray_gradients ? 1 : 0];
  if (!kernel) {
    BuildOptions options = tile_options(variant_);
    kernel.emplace(
        Program(device_,
                "kernels/render_bwd.cl",
                options.define("ERRORS", extras.errors).define("RAY_GRADIENTS", extras.ray_gradients)),
        "render_bwd");
  }
  return *kernel;
}

void RenderStage::run(const shared::FrameParams& frame,
                      const ParticleBuffers& particles,
                      const RayBuffers& rays,
                      FrameBuffers& b) {
  const auto work_items = static_cast<std::size_t>(variant_.shape.work_items);
  b.out.reserve(std::size_t{SIM_OUTPUTS} * frame.slots);
  render_.launch(std::size_t{frame.tiles_x} * frame.tiles_y * work_items,
                 work_items,
                 frame,
                 b.sensor,
                 b.world_ray,
                 rays.u,
                 b.first,
                 b.payload,
                 b.records,
                 b.motions,
                 b.keys,
                 particles.params,
                 particles.actor_of,
                 b.actors,
                 b.out);
}

void RenderStage::run_backward(const shared::FrameParams& frame,
                               const RayBuffers& rays,
                               FrameBuffers& b,
                               const BackwardExtras& extras) {
  const auto work_items = static_cast<std::size_t>(variant_.shape.work_items);
  if (extras.errors) b.instance_error.reserve(b.instances);
  if (extras.ray_gradients) b.ray_grads.reserve((variant_.origins ? 6U : 3U) * std::size_t{frame.slots});
  b.grads.reserve(std::size_t{b.instances} * SIM_GRAD);
  backward(extras).launch(std::size_t{frame.tiles_x} * frame.tiles_y * work_items,
                          work_items,
                          frame,
                          b.sensor,
                          b.world_ray,
                          rays.u,
                          b.first,
                          b.payload,
                          b.records,
                          b.motions,
                          b.footprints,
                          b.emission,
                          b.out,
                          b.grad_out,
                          b.grads,
                          b.ray_error,
                          b.instance_error,
                          b.ray_grads);
}

}  // namespace simuli
