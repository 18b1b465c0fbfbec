// Launcher of "kernels/project.cl" and "kernels/project_bwd.cl".
#include "host/render/frame/stages.hpp"
#include "host/render/rays/frame_constants.hpp"

namespace simuli {
namespace {

constexpr std::size_t kLocalSize = 32;

/// Only the forward projection asks for these: other kernels are one program for all.
BuildOptions forward_options(const Variant& variant) {
  BuildOptions options = variant.options();
  if (variant.order == Order::kPerRay) options.define("PER_RAY", true);
  return options.define("EXTENT", variant.extent)
      .define("SHUTTER_ITERATIONS", variant.shutter_iterations)
      .define("COMPENSATION", variant.compensation)
      .define("CULLING", variant.culling);
}

BuildOptions backward_options(const Variant& variant) {
  BuildOptions options = variant.options();
  // Colour is clamped at 0 in all three channels, of a LiDAR's features the intensity alone.
  return options.define("CLAMPED_CHANNELS", variant.sensor == SensorType::kCamera ? 3 : 1)
      .define("COMPENSATION", variant.compensation);
}

}  // namespace

ProjectStage::ProjectStage(const Device& device, const Variant& variant)
    : lanes_(variant.shape.lanes),
      actors_(variant.actors),
      actor_motion_(variant.actor_motion),
      normal_samples_(device, "normal samples", variant.precision),
      project_(Program(device, "kernels/project.cl", forward_options(variant)), "project"),
      project_bwd_(Program(device, "kernels/project_bwd.cl", backward_options(variant)), "project_bwd") {
  if (variant.projection == Projection::kMonteCarlo) normal_samples_.assign(normal_samples());
}

void ProjectStage::run(const shared::FrameParams& frame,
                       const ParticleBuffers& particles,
                       const RayBuffers& rays,
                       FrameBuffers& buffers) {
  buffers.records.reserve(std::size_t{frame.particles} * SIM_RECORD);
  buffers.footprints.reserve(frame.particles);
  buffers.keys.reserve(frame.particles);
  if (actor_motion_) buffers.motions.reserve(std::size_t{frame.particles} * SIM_MOTION);
  const std::size_t items =
      round_up(frame.particles, static_cast<std::size_t>(lanes_)) / static_cast<std::size_t>(lanes_);
  project_.launch(round_up(items, kLocalSize),
                  kLocalSize,
                  frame,
                  particles.params,
                  particles.actor_of,
                  buffers.actors,
                  buffers.sensor,
                  rays.row_lut,
                  rays.row_elevation,
                  rays.tile_row_of_row,
                  rays.column_of_bin,
                  rays.mask_row_of_row,
                  rays.areas,
                  normal_samples_,
                  buffers.records,
                  buffers.footprints,
                  buffers.keys,
                  buffers.motions);
}

void ProjectStage::run_backward(const shared::FrameParams& frame,
                                const ParticleBuffers& particles,
                                FrameBuffers& buffers,
                                RealBuffer& param_grads) {
  if (actors_) buffers.pose_grads.reserve(std::size_t{SIM_POSE_GRAD} * frame.stride);
  const std::size_t items =
      round_up(frame.particles, static_cast<std::size_t>(lanes_)) / static_cast<std::size_t>(lanes_);
  project_bwd_.launch(round_up(items, kLocalSize),
                      kLocalSize,
                      frame,
                      particles.params,
                      particles.actor_of,
                      buffers.actors,
                      buffers.sensor,
                      buffers.keys,
                      buffers.footprints,
                      buffers.emission,
                      buffers.records,
                      buffers.motions,
                      buffers.grads,
                      param_grads,
                      buffers.pose_grads);
}

}  // namespace simuli
