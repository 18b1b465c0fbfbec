// Launcher of "kernels/pose_bwd.cl".
#include "host/render/train/pose_gradient.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace simuli {
namespace {

Program program(const Device& device, const Variant& variant) {
  return {device, "kernels/pose_bwd.cl", variant.options()};
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

std::pair<Pose, Pose> moved_by(const PoseTangent& tangent, const Pose& start, const Pose& end) {
  const Eigen::Quaterniond half_way = start.rotation.slerp(0.5, end.rotation);
  const Eigen::Vector3d step = half_way * tangent.translation;
  const double angle = tangent.rotation.norm();
  const Eigen::Quaterniond turn(angle > 0.0 ? Eigen::AngleAxisd(angle, tangent.rotation / angle)
                                            : Eigen::AngleAxisd::Identity());
  std::pair<Pose, Pose> moved{start, end};
  for (Pose* pose : {&moved.first, &moved.second}) {
    pose->translation += step;
    pose->rotation = pose->rotation * turn;
  }
  return moved;
}

PoseStage::PoseStage(const Device& device, const Variant& variant)
    : device_(device),
      ray_sums_(device, "pose sums of rays", variant.precision),
      particle_sums_(device, "pose sums of particles", variant.precision),
      rays_(program(device, variant), "rays_torque"),
      particles_(program(device, variant), "particles_force") {}

PoseGradient PoseStage::run(const shared::FrameParams& frame,
                            const RayBuffers& rays,
                            const FrameBuffers& buffers,
                            const RealBuffer& param_grads) {
  const Chunks slots = chunks_of(device_, frame.slots);
  // Whole vectors to each work-item: slots come in tiles.
  const auto chunk = static_cast<std::uint32_t>(round_up(slots.chunk, SIM_SLOT_ROW));
  ray_sums_.reserve(3 * ((frame.slots + chunk - 1) / chunk));
  rays_.launch(
      ray_sums_.count() / 3, 1, frame, chunk, buffers.sensor, rays.sensor_ray, buffers.ray_grads, ray_sums_);
  const Chunks particles = chunks_of(device_, frame.particles);
  particle_sums_.reserve(3 * particles.work_items);
  particles_.launch(
      particles.work_items, 1, frame, particles.chunk, buffers.keys, param_grads, particle_sums_);

  PoseGradient gradient;
  gradient.rotation = sum_of(ray_sums_);
  std::array<double, shared::kReals<shared::SensorConstants>> reals{};
  std::ranges::copy(buffers.sensor.download_double(), reals.begin());
  const auto constants = shared::from_reals<shared::SensorConstants>(reals);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> sensor_from_scene(
      constants.rotation_ref);
  // The sensor moves as all particles would the other way.
  gradient.translation = -(sensor_from_scene * sum_of(particle_sums_));
  return gradient;
}

}  // namespace simuli
