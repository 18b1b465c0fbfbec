#include "host/render/frame/actor_constants.hpp"

#include <algorithm>
#include <cmath>

#include "cl/shared/layout.h"

namespace simuli {

std::vector<double> actor_constants(const std::vector<ActorView>& actors,
                                    const Eigen::Vector3d& centre_ref,
                                    bool& motion) {
  motion = false;
  std::vector<double> values((actors.size() + 1) * SIM_ACTOR_REALS, 0.0);
  for (std::size_t i = 0; i <= actors.size(); ++i) {
    double* row = values.data() + i * SIM_ACTOR_REALS;
    const auto put = [row](int at, const Eigen::Vector3d& v) { std::copy_n(v.data(), 3, row + at); };
    for (int k = 0; k < 3; ++k) row[SIM_A_ROTATION + 4 * k] = 1.0;
    row[SIM_A_AXIS] = 1.0;
    row[SIM_A_THERE] = i == 0 || actors[i - 1].is_there ? 1.0 : 0.0;
    if (i == 0 || !actors[i - 1].is_there) continue;
    const Pose& a = actors[i - 1].scene_from_actor_start;
    const Pose& b = actors[i - 1].scene_from_actor_end;
    a.check(fmt::format("actor {}", i - 1));
    b.check(fmt::format("actor {}", i - 1));
    const Pose middle = interpolate(a, b, 0.5);
    put(SIM_A_CENTRE, middle.translation - centre_ref);
    put(SIM_A_STEP, b.translation - a.translation);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = middle.rotation.toRotationMatrix();
    std::copy_n(rotation.data(), 9, row + SIM_A_ROTATION);
    // By the shorter arc, as slerp takes it; the axis is the same in the scene at all times of the turn.
    Eigen::Quaterniond turn = b.rotation * a.rotation.conjugate();
    if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
    const double sine = turn.vec().norm();
    if (sine > 0.0) put(SIM_A_AXIS, turn.vec() / sine);
    row[SIM_A_ANGLE] = 2.0 * std::atan2(sine, turn.w());
    motion = motion || row[SIM_A_ANGLE] > 1e-9 || (b.translation - a.translation).norm() > 1e-9;
  }
  return values;
}

}  // namespace simuli
