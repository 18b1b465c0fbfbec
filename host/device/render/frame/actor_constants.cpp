#include "host/device/render/frame/actor_constants.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cl/shared/sensor_constants.h"

namespace simuli {
namespace {

/// Upper bound in m of a deformation's displacements during the frame, rounded up for float.
double reach_of(const DeformationView& shape) {
  double squared = 0.0;
  for (const std::vector<double>* const offsets : {&shape.start_m, &shape.end_m}) {
    for (std::size_t i = 0; i + 2 < offsets->size(); i += 3)
      squared = std::max(squared, Eigen::Vector3d(offsets->data() + i).squaredNorm());
  }
  return 1.00001 * std::sqrt(squared);
}

}  // namespace

std::vector<double> actor_constants(const std::vector<ActorView>& actors,
                                    const Eigen::Vector3d& centre_ref,
                                    bool& motion) {
  motion = false;
  std::vector<double> values;
  for (std::size_t i = 0; i <= actors.size(); ++i) {
    shared::ActorConstants<double> row{};
    const auto put = [](const Eigen::Vector3d& v, double* to) { std::copy_n(v.data(), 3, to); };
    for (int k = 0; k < 3; ++k) row.rotation[4 * k] = 1.0;
    row.turn_axis[0] = 1.0;
    const bool is_there = i == 0 || actors[i - 1].is_there;
    row.there = !is_there ? 0.0 : i == 0 ? 1.0 : actors[i - 1].share;
    if (i > 0 && is_there) {
      const Pose& a = actors[i - 1].scene_from_actor_start;
      const Pose& b = actors[i - 1].scene_from_actor_end;
      a.check(fmt::format("actor {}", i - 1));
      b.check(fmt::format("actor {}", i - 1));
      const Pose middle = interpolate(a, b, 0.5);
      put(middle.translation - centre_ref, row.centre);
      put(b.translation - a.translation, row.step);
      const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = middle.rotation.toRotationMatrix();
      std::copy_n(rotation.data(), 9, row.rotation);
      // The shorter arc, as in slerp; the rotation axis is constant in the scene.
      Eigen::Quaterniond turn = b.rotation * a.rotation.conjugate();
      if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
      const double sine = turn.vec().norm();
      if (sine > 0.0) put(turn.vec() / sine, row.turn_axis);
      row.reach = reach_of(actors[i - 1].deformation);
      row.turn_angle = 2.0 * std::atan2(sine, turn.w());
      motion = motion || row.turn_angle > 1e-9 || (b.translation - a.translation).norm() > 1e-9;
    }
    const auto reals = shared::reals_of(row);
    values.insert(values.end(), reals.begin(), reals.end());
  }
  return values;
}

}  // namespace simuli
