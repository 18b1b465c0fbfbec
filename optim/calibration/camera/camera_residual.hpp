#pragma once
// Distance of a depth edge from a picture edge, for Ceres.
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/trajectory.hpp"
#include "optim/calibration/lens/lens_jets.hpp"
#include "optim/calibration/path/residuals.hpp"

namespace simuli::calibration {

/// A camera, which must outlive this, with its lens's constants as Jets, 10 kB that points share.
struct JetCamera {
  explicit JetCamera(const Camera& a_camera)
      : camera(a_camera), lens(lens_jets::constants_of(a_camera.lens)) {}
  const Camera& camera;
  lens_jets::Constants lens;
};

/// Pixel of a point in the camera's frame with its derivatives [2 x 3]; false without image.
inline bool pixel_of(const JetCamera& jets,
                     const Eigen::Vector3d& p_camera,
                     Eigen::Vector2d& pixel,
                     Eigen::Matrix<double, 2, 3>& slope) {
  using lens_jets::F;
  const Camera& camera = jets.camera;
  F u(0.0);
  F v(0.0);
  const bool valid = lens_jets::project(
      camera.lens.kind(), jets.lens, F(p_camera.x(), 0), F(p_camera.y(), 1), F(p_camera.z(), 2), u, v);
  if (!valid) return false;
  pixel = {camera.fx * u.a + camera.cx, camera.fy * v.a + camera.cy};
  slope.row(0) = camera.fx * u.v.head<3>().transpose();
  slope.row(1) = camera.fy * v.v.head<3>().transpose();
  return true;
}

/// The same for a point of Jets: applies the chain rule to the lens code.
template <int N>
bool pixel_of(const JetCamera& camera, const ceres::Jet<double, N>* p_camera, ceres::Jet<double, N>* pixel) {
  Eigen::Vector2d value;
  Eigen::Matrix<double, 2, 3> slope;
  if (!pixel_of(camera, {p_camera[0].a, p_camera[1].a, p_camera[2].a}, value, slope)) return false;
  for (int i = 0; i < 2; ++i) {
    pixel[i] = ceres::Jet<double, N>(value[i]);
    for (int k = 0; k < 3; ++k) pixel[i].v += slope(i, k) * p_camera[k].v;
  }
  return true;
}

inline bool pixel_of(const JetCamera& jets, const double* p_camera, double* pixel) {
  Eigen::Vector2d value;
  if (!jets.camera.project({p_camera[0], p_camera[1], p_camera[2]}, value)) return false;
  pixel[0] = value.x();
  pixel[1] = value.y();
  return true;
}

/// Signed distance, over sigma_px, of a world point's pixel from a line in the picture. The camera is mounted
/// by rig_from_camera, a PoseBlock; the rig is at share u between pose 0 and pose 1 at the pixel's recorded
/// time, shifted by time_offset.
struct PointOnLine {
  const JetCamera* camera;
  Eigen::Vector3d p_world;
  TimedPose from;
  TimedPose to;
  double time_s;
  Eigen::Vector2d on_line;
  Eigen::Vector2d normal;
  double sigma_px;

  template <class T>
  bool operator()(const T* rig_from_camera, const T* time_offset, T* out) const {
    const PoseBlock start(from.pose);
    const PoseBlock end(to.pose);
    const double span_s = to.time_s - from.time_s;
    double whole_turn[3];
    relative_rotation(start.data(), end.data(), whole_turn);
    const T u = (T(time_s - from.time_s) + time_offset[0]) / T(span_s);
    // world -> rig at that time -> camera
    T p[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = T(p_world[k]) - (T(1.0) - u) * T(from.pose.translation[k]) - u * T(to.pose.translation[k]);
    }
    const double* const q = start.data();
    const T start_from_world[4] = {T(q[0]), T(-q[1]), T(-q[2]), T(-q[3])};
    T in_start[3];
    ceres::UnitQuaternionRotatePoint(start_from_world, p, in_start);
    const T back[3] = {-u * T(whole_turn[0]), -u * T(whole_turn[1]), -u * T(whole_turn[2])};
    T p_rig[3];
    ceres::AngleAxisRotatePoint(back, in_start, p_rig);
    for (int k = 0; k < 3; ++k) p_rig[k] -= rig_from_camera[4 + k];
    const T camera_from_rig[4] = {
        rig_from_camera[0], -rig_from_camera[1], -rig_from_camera[2], -rig_from_camera[3]};
    T p_camera[3];
    ceres::UnitQuaternionRotatePoint(camera_from_rig, p_rig, p_camera);
    T pixel[2];
    if (!pixel_of(*camera, p_camera, pixel)) return false;
    out[0] = ((pixel[0] - T(on_line.x())) * T(normal.x()) + (pixel[1] - T(on_line.y())) * T(normal.y())) /
             T(sigma_px);
    return true;
  }
};

}  // namespace simuli::calibration
