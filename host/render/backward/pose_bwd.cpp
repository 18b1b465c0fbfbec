// Launcher of "kernels/pose_bwd.cl".
#include "host/render/backward/pose_bwd.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace simuli {
namespace {

Program program(const Device& device, const Variant& variant) {
  return {device, "kernels/pose_bwd.cl", variant.build_options()};
}

Eigen::Vector3d sum_of(const RealBuffer& parts) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const std::vector<double> values = parts.download_double();
  for (std::size_t i = 0; i + 3 <= values.size(); i += 3) {
    sum += Eigen::Map<const Eigen::Vector3d>(values.data() + i);
  }
  return sum;
}

}  // namespace

PoseStage::PoseStage(const Device& device, const Variant& variant)
    : device_(device),
      buffers_(device, variant.options.precision),
      rays_(program(device, variant), "rays_torque"),
      particles_(program(device, variant), "particles_force") {}

PoseGradient PoseStage::run(const shared::FrameParams& frame,
                            const RayBuffers& rays,
                            const FrameConstants& constants,
                            const Projected& projected,
                            const GradientBuffers& gradients,
                            const RealBuffer& param_grads) {
  const Chunks slots = chunks_of(device_, frame.slots);
  // Whole vectors to each work-item: slots come in tiles.
  const auto chunk = static_cast<std::uint32_t>(round_up(slots.chunk, SIM_SLOT_ROW));
  const Chunks particles = chunks_of(device_, frame.particles);
  const std::size_t ray_items = round_up((frame.slots + chunk - 1) / chunk, slots.group);
  buffers_.reserve({ray_items, particles.work_items});
  rays_.run(ray_items,
            slots.group,
            {{"frame", frame}, {"chunk", chunk}, constants, rays, gradients, {"sums", buffers_.ray_sums}});
  particles_.run(particles.work_items,
                 particles.group,
                 {{"frame", frame},
                  {"chunk", particles.chunk},
                  projected,
                  {"param_grads", param_grads},
                  {"sums", buffers_.particle_sums}});

  PoseGradient gradient;
  gradient.rotation = sum_of(buffers_.ray_sums);
  std::array<double, shared::kReals<shared::SensorConstants>> reals{};
  std::ranges::copy(constants.sensor.download_double(), reals.begin());
  const auto sensor = shared::from_reals<shared::SensorConstants>(reals);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> sensor_from_scene(sensor.rotation_ref);
  // The sensor moves as all particles would the other way.
  gradient.translation = -(sensor_from_scene * sum_of(buffers_.particle_sums));
  return gradient;
}

}  // namespace simuli
