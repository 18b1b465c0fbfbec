#include "host/device/render/scene/sensor_in_frame.hpp"

#include <algorithm>
#include <cmath>

#include "host/core/base/angles.hpp"

namespace simuli {
namespace {

void put(const Eigen::Vector3d& from, double* to) { std::copy_n(from.data(), 3, to); }

/// sensor_from_scene, row-major.
void put_inverse(const Eigen::Quaterniond& scene_from_sensor, double* to) {
  const Eigen::Matrix3d m = scene_from_sensor.toRotationMatrix();
  for (Eigen::Index k = 0; k < 9; ++k) to[k] = m(k % 3, k / 3);
}

}  // namespace

SensorInFrame sensor_in_frame(const SensorRays& rays,
                              const Pose& scene_from_sensor_start,
                              const Pose& scene_from_sensor_end,
                              const RenderOptions& options,
                              const std::array<float, 3>& background,
                              const RayDrop::Parameters& drop) {
  const RayGrid& grid = rays.grid();
  SensorInFrame out;
  auto& c = out.constants;
  c.model = rays.model();
  const Pose& a = scene_from_sensor_start;
  const Pose& b = scene_from_sensor_end;
  a.check("the sensor");
  b.check("the sensor");
  const Pose middle = interpolate(a, b, 0.5);
  put(middle.translation, c.centre_ref);
  put(Eigen::Vector3d(b.translation - a.translation), c.centre_step);
  put_inverse(a.rotation, c.rotation_start);
  put_inverse(middle.rotation, c.rotation_ref);

  // The rotation from start to end in the sensor frame, by the shorter arc as in slerp.
  Eigen::Quaterniond turn = a.rotation.conjugate() * b.rotation;
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  c.turn_angle = 2.0 * std::atan2(sine, turn.w());
  put(sine > 0.0 ? Eigen::Vector3d(turn.vec() / sine) : Eigen::Vector3d::UnitX(), c.turn_axis);
  // Motion below the resolution of float poses counts as none: 1e-9 m and rad over the frame.
  out.moving = c.turn_angle > 1e-9 || (b.translation - a.translation).norm() > 1e-9;

  c.alpha_cut = options.alpha_cut;
  c.transmittance_cut = options.transmittance_cut;
  for (std::size_t k = 0; k < 3; ++k) c.background[k] = static_cast<double>(background[k]);
  if (options.detail > 0.0) c.detail_reach = c.model.rays_per_rad / options.detail;
  c.drop = shared::from_reals<shared::DropConstants>(drop);
  if (grid.type == SensorType::kCamera) {
    const double cone = std::min(grid.view_angle + c.turn_angle / 2.0 + 1e-4, kPi);
    c.cos_view = std::cos(cone);
    c.sin_view = std::sin(cone);
  }
  return out;
}

}  // namespace simuli
