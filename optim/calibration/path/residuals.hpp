#pragma once
// Residuals for Ceres. Those with few blocks are written once for doubles and Jets (automatic derivatives);
// points on planes, hundreds of thousands in a log, have analytic derivatives. Included by the sources of this
// folder, of camera/ and their tests.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <ceres/autodiff_cost_function.h>
#include <ceres/manifold.h>
#include <ceres/product_manifold.h>
#include <ceres/rotation.h>
#include <ceres/sized_cost_function.h>
#include <cmath>

#include "host/core/base/pose.hpp"

namespace simuli::calibration {

/// Standard deviation of a return from its plane.
inline constexpr double kPointSigma_m = 0.02;

/// A pose as a Ceres parameter block: a quaternion (w, x, y, z), then the translation. One block, so that block
/// operations of solvers treat six degrees of freedom at once.
struct PoseBlock {
  static constexpr int kSize = 7;
  using Manifold = ceres::ProductManifold<ceres::QuaternionManifold, ceres::EuclideanManifold<3>>;
  std::array<double, kSize> numbers{1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};

  PoseBlock() = default;
  explicit PoseBlock(const Pose& pose)
      : numbers{pose.rotation.w(),
                pose.rotation.x(),
                pose.rotation.y(),
                pose.rotation.z(),
                pose.translation.x(),
                pose.translation.y(),
                pose.translation.z()} {}
  [[nodiscard]] double* data() { return numbers.data(); }
  [[nodiscard]] const double* data() const { return numbers.data(); }
  [[nodiscard]] Pose pose() const { return pose_of(numbers.data()); }
  [[nodiscard]] static Pose pose_of(const double* numbers) {
    return {Eigen::Quaterniond(numbers[0], numbers[1], numbers[2], numbers[3]).normalized(),
            {numbers[4], numbers[5], numbers[6]}};
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

/// A point of the rig at share u between two poses: slerp and centre lerp, as in host/core/base/pose.hpp.
class MovedPoint {
 public:
  /// `start`, `end`: numbers of PoseBlocks.
  MovedPoint(const double* start, const double* end, double u, const Eigen::Vector3d& p_rig)
      : start_(PoseBlock::pose_of(start)), end_(PoseBlock::pose_of(end)), u_(u) {
    turn_ = Eigen::AngleAxisd(start_.rotation.conjugate() * end_.rotation);
    arm_ = start_.rotation * (Eigen::AngleAxisd(u * turn_.angle(), turn_.axis()) * p_rig);
    p_world_ = arm_ + (1.0 - u) * start_.translation + u * end_.translation;
  }
  [[nodiscard]] const Eigen::Vector3d& p_world() const { return p_world_; }

  /// Derivatives of (along * p_world) by the numbers of both poses (null: not requested), on their manifold.
  ///
  /// Rotating the poses by small a and b about the world's axes rotates the interpolated pose by a + M (b - a).
  /// Perpendicular to the axis of the whole rotation t, in the complex plane whose unit is a quarter rotation
  /// about it, M is (1 - exp(i u t)) / (1 - exp(i t)) = exp(-i (1 - u) t / 2) sin(u t / 2) / sin(t / 2); along
  /// the axis it is u.
  void differentiate(const Eigen::Vector3d& along, double* by_start, double* by_end) const {
    const Eigen::Vector3d by_turn = arm_.cross(along);
    const Eigen::Vector3d axis = start_.rotation * turn_.axis();
    const double half = 0.5 * turn_.angle();
    const double ratio = half > kLeastTurn_rad ? std::sin(u_ * half) / std::sin(half) : u_;
    const double angle = (1.0 - u_) * half;
    const Eigen::Vector3d parallel = axis.dot(by_turn) * axis, across = by_turn - parallel;
    const Eigen::Vector3d of_end =
        u_ * parallel + ratio * (std::cos(angle) * across + std::sin(angle) * axis.cross(across));
    if (by_start != nullptr) put(start_.rotation, by_turn - of_end, (1.0 - u_) * along, by_start);
    if (by_end != nullptr) put(end_.rotation, of_end, u_ * along, by_end);
  }

 private:
  static constexpr double kLeastTurn_rad = 1e-9;

  /// Ceres rotates q to (1, d) q: returns the derivative by q that gives 2 by_turn along each d, and 0 along q.
  static void put(const Eigen::Quaterniond& q,
                  const Eigen::Vector3d& by_turn,
                  const Eigen::Vector3d& by_translation,
                  double* numbers) {
    const Eigen::Vector3d turn = 2.0 * by_turn;
    Eigen::Map<Eigen::Matrix<double, PoseBlock::kSize, 1>> out(numbers);
    out << -turn.dot(q.vec()), q.w() * turn + turn.cross(q.vec()), by_translation;
  }

  Pose start_, end_;
  double u_;
  Eigen::AngleAxisd turn_;  // from start to end, about an axis of the rig at the start
  Eigen::Vector3d arm_, p_world_;
};

/// Distance of an interpolated point from a plane, over sigma_m.
class PointOnPlane final : public ceres::SizedCostFunction<1, PoseBlock::kSize, PoseBlock::kSize> {
 public:
  PointOnPlane(const Eigen::Vector3d& p_rig,
               double u,
               const Eigen::Vector3d& centre,
               const Eigen::Vector3d& normal,
               double sigma_m)
      : p_rig_(p_rig), u_(u), centre_(centre), weighted_normal_(normal / sigma_m) {}

  bool Evaluate(double const* const* blocks, double* out, double** derivatives) const override {
    const MovedPoint moved(blocks[0], blocks[1], u_, p_rig_);
    out[0] = weighted_normal_.dot(moved.p_world() - centre_);
    if (derivatives != nullptr) moved.differentiate(weighted_normal_, derivatives[0], derivatives[1]);
    return true;
  }

 private:
  Eigen::Vector3d p_rig_;
  double u_;  // share between the two poses
  Eigen::Vector3d centre_, weighted_normal_;
};

/// The same with an unknown plane: tilted by plane[0], plane[1] (slopes along `first` and `second`, which form
/// a frame with the normal) and shifted by plane[2] m along its normal.
class PointOnFreePlane : public ceres::SizedCostFunction<1, PoseBlock::kSize, PoseBlock::kSize, 3> {
 public:
  PointOnFreePlane(const Eigen::Vector3d& p_rig,
                   double u,
                   const Eigen::Vector3d& centre,
                   const Eigen::Vector3d& normal,
                   double sigma_m)
      : p_rig_(p_rig),
        u_(u),
        centre_(centre),
        normal_(normal),
        first_(normal.unitOrthogonal()),
        second_(normal.cross(first_)),
        sigma_m_(sigma_m) {}

  bool Evaluate(double const* const* blocks, double* out, double** derivatives) const override {
    const MovedPoint moved(blocks[0], blocks[1], u_, p_rig_);
    const double* const plane = blocks[2];
    const Eigen::Vector3d off = moved.p_world() - centre_;
    const double weight = 1.0 / (sigma_m_ * std::sqrt(1.0 + plane[0] * plane[0] + plane[1] * plane[1]));
    const Eigen::Vector3d tilted = weight * (normal_ + plane[0] * first_ + plane[1] * second_);
    const double distance = tilted.dot(off);
    out[0] = distance - plane[2] / sigma_m_;
    if (derivatives == nullptr) return true;
    moved.differentiate(tilted, derivatives[0], derivatives[1]);
    if (derivatives[2] != nullptr) {
      const double shrunk = distance * weight * weight * sigma_m_ * sigma_m_;
      derivatives[2][0] = weight * first_.dot(off) - shrunk * plane[0];
      derivatives[2][1] = weight * second_.dot(off) - shrunk * plane[1];
      derivatives[2][2] = -1.0 / sigma_m_;
    }
    return true;
  }

 private:
  Eigen::Vector3d p_rig_;
  double u_;
  Eigen::Vector3d centre_, normal_, first_, second_;
  double sigma_m_;
};

/// A pose relative to its prior: rotation vector over sigma_rad, then translation over sigma_m.
struct PosePrior {
  PoseBlock believed;
  double sigma_rad;
  double sigma_m;

  template <class T>
  bool operator()(const T* pose, T* out) const {
    const double* const from = believed.data();
    const T rotation[4] = {T(from[0]), T(from[1]), T(from[2]), T(from[3])};
    relative_rotation(rotation, pose, out);
    for (int k = 0; k < 3; ++k) {
      out[k] /= T(sigma_rad);
      out[3 + k] = (pose[4 + k] - from[4 + k]) / T(sigma_m);
    }
    return true;
  }
};

}  // namespace simuli::calibration
