#pragma once
// Residuals for Ceres, written once for doubles and Jets (automatic derivatives). Rotations are quaternions
// (w, x, y, z). Included by the sources of this folder and their tests alone.
#include <Eigen/Core>
#include <array>
#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include "host/core/base/pose.hpp"

namespace simuli::calibration {

/// Of a return about the plane that it lies on.
inline constexpr double kPointSigma_m = 0.02;

/// A pose as Ceres changes it.
struct PoseBlock {
  std::array<double, 4> rotation{1.0, 0.0, 0.0, 0.0};
  std::array<double, 3> translation{0.0, 0.0, 0.0};

  PoseBlock() = default;
  explicit PoseBlock(const Pose& pose)
      : rotation{pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()},
        translation{pose.translation.x(), pose.translation.y(), pose.translation.z()} {}
  [[nodiscard]] Pose pose() const {
    return {Eigen::Quaterniond(rotation[0], rotation[1], rotation[2], rotation[3]).normalized(),
            {translation[0], translation[1], translation[2]}};
  }
};

/// a_from_b^-1 * a_from_c as a rotation vector: rad about the axes of b.
template <class T>
void relative_rotation(const T* a_from_b, const T* a_from_c, T* b_from_c) {
  const T b_from_a[4] = {a_from_b[0], -a_from_b[1], -a_from_b[2], -a_from_b[3]};
  T turn[4];
  ceres::QuaternionProduct(b_from_a, a_from_c, turn);
  ceres::QuaternionToAngleAxis(turn, b_from_c);
}

/// p in world at share u of the way from pose 0 to pose 1: slerp and centre lerp, as host/core/base/pose.hpp.
template <class T>
void moved_point(const T* rotation_0,
                 const T* translation_0,
                 const T* rotation_1,
                 const T* translation_1,
                 double u,
                 const Eigen::Vector3d& p_rig,
                 T* p_world) {
  T turn[3];
  relative_rotation(rotation_0, rotation_1, turn);
  for (T& angle : turn) angle *= T(u);
  const T p[3] = {T(p_rig.x()), T(p_rig.y()), T(p_rig.z())};
  T in_rig_0[3];
  ceres::AngleAxisRotatePoint(turn, p, in_rig_0);
  ceres::UnitQuaternionRotatePoint(rotation_0, in_rig_0, p_world);
  for (int k = 0; k < 3; ++k) p_world[k] += T(1.0 - u) * translation_0[k] + T(u) * translation_1[k];
}

/// Distance of a moved point from a plane, over sigma_m.
struct PointOnPlane {
  Eigen::Vector3d p_rig;
  double u;  // share of the way between the two poses
  Eigen::Vector3d centre;
  Eigen::Vector3d normal;
  double sigma_m;

  template <class T>
  bool operator()(const T* rotation_0,
                  const T* translation_0,
                  const T* rotation_1,
                  const T* translation_1,
                  T* out) const {
    T p[3];
    moved_point(rotation_0, translation_0, rotation_1, translation_1, u, p_rig, p);
    out[0] = ((p[0] - centre.x()) * normal.x() + (p[1] - centre.y()) * normal.y() +
              (p[2] - centre.z()) * normal.z()) /
             T(sigma_m);
    return true;
  }
};

/// The same where the plane is unknown too: it is tilted by plane[0], plane[1] (slopes along `first` and
/// `second`, which with the normal make a frame) and moved by plane[2] m along its normal.
struct PointOnFreePlane {
  Eigen::Vector3d p_rig;
  double u;
  Eigen::Vector3d centre;
  Eigen::Vector3d normal;
  Eigen::Vector3d first;
  Eigen::Vector3d second;
  double sigma_m;

  template <class T>
  bool operator()(const T* rotation_0,
                  const T* translation_0,
                  const T* rotation_1,
                  const T* translation_1,
                  const T* plane,
                  T* out) const {
    T p[3];
    moved_point(rotation_0, translation_0, rotation_1, translation_1, u, p_rig, p);
    T along[3] = {T(0.0), T(0.0), T(0.0)};  // normal, first, second
    for (int k = 0; k < 3; ++k) {
      const T d = p[k] - centre[k];
      along[0] += d * normal[k];
      along[1] += d * first[k];
      along[2] += d * second[k];
    }
    const T length = sqrt(T(1.0) + plane[0] * plane[0] + plane[1] * plane[1]);
    out[0] = ((along[0] + plane[0] * along[1] + plane[1] * along[2]) / length - plane[2]) / T(sigma_m);
    return true;
  }
};

/// A pose against what is believed of it: rotation vector over sigma_rad, then translation over sigma_m.
struct PosePrior {
  PoseBlock believed;
  double sigma_rad;
  double sigma_m;

  template <class T>
  bool operator()(const T* rotation, const T* translation, T* out) const {
    const T from[4] = {
        T(believed.rotation[0]), T(believed.rotation[1]), T(believed.rotation[2]), T(believed.rotation[3])};
    relative_rotation(from, rotation, out);
    for (int k = 0; k < 3; ++k) {
      out[k] /= T(sigma_rad);
      out[3 + k] = (translation[k] - believed.translation[k]) / T(sigma_m);
    }
    return true;
  }
};

}  // namespace simuli::calibration
