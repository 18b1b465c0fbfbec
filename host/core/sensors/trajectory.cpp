#include "host/core/sensors/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/core/base/error.hpp"

namespace simuli {

Trajectory::Trajectory(std::vector<TimedPose> poses) : poses_(std::move(poses)) {
  if (poses_.empty()) throw_input_error("trajectory", "poses", "0", "at least 1");
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const auto& p = poses_[i];
    const bool finite = std::isfinite(p.time_s) && p.pose.translation.allFinite() &&
                        p.pose.rotation.coeffs().allFinite();
    if (!finite) throw_input_error("trajectory", fmt::format("poses[{}]", i), "NaN or Inf", "finite");
    // Half of the labels' limit, so that objects near the path are within it.
    const double far_m = p.pose.translation.cwiseAbs().maxCoeff();
    if (far_m > 0.5 * kFarthestPosition_m) {
      throw_input_error("trajectory",
                        fmt::format("poses[{}]", i),
                        fmt::format("a place at {} m", far_m),
                        fmt::format("up to {} m", 0.5 * kFarthestPosition_m));
    }
    if (!(p.pose.rotation.norm() > 1e-6)) {
      throw_input_error("trajectory", fmt::format("poses[{}].rotation", i), "a zero quaternion", "any other");
    }
    if (i > 0 && !(p.time_s > poses_[i - 1].time_s)) {
      throw_input_error("trajectory",
                        fmt::format("poses[{}].time", i),
                        fmt::format("{} s after {} s", p.time_s, poses_[i - 1].time_s),
                        "strictly increasing times");
    }
    poses_[i].pose.rotation.normalize();
  }
}

bool Trajectory::covers(double time_s) const {
  return !poses_.empty() && time_s >= start_s() - kExtrapolation_s && time_s <= end_s() + kExtrapolation_s;
}

Pose Trajectory::at(double time_s) const {
  if (!covers(time_s)) {
    throw_input_error("trajectory",
                      "time",
                      fmt::format("{:.16g} s", time_s),
                      fmt::format("{:.16g} to {:.16g} s, and {} s beyond either end",
                                  start_s(),
                                  end_s(),
                                  kExtrapolation_s));
  }
  if (poses_.size() == 1) return poses_.front().pose;
  auto next = std::upper_bound(poses_.begin(), poses_.end(), time_s, [](double t, const TimedPose& p) {
    return t < p.time_s;
  });
  next = std::clamp(next, poses_.begin() + 1, poses_.end() - 1);
  const TimedPose& a = *(next - 1);
  const TimedPose& b = *next;
  return interpolate(a.pose, b.pose, (time_s - a.time_s) / (b.time_s - a.time_s));
}

}  // namespace simuli
