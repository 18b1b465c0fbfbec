#pragma once
#include <vector>

#include "host/core/base/pose.hpp"

namespace simuli {

struct TimedPose {
  double time_s = 0.0;  // seconds since the start of the log
  Pose pose;            // world_from_rig
};

/// Timed world_from_rig poses, strictly increasing in time, interpolated by slerp + centre lerp.
class Trajectory {
 public:
  Trajectory() = default;
  /// Throws Error{kInput} when empty, not strictly increasing in time, not finite, or with a zero rotation.
  explicit Trajectory(std::vector<TimedPose> poses);

  /// Returns world_from_rig at time_s. Extrapolates the end segments at constant velocity up to
  /// `kExtrapolation_s` outside the recorded span; beyond, throws Error{kInput} with time and span.
  [[nodiscard]] Pose at(double time_s) const;
  /// Whether there is a pose at time_s.
  [[nodiscard]] bool covers(double time_s) const;

  [[nodiscard]] const std::vector<TimedPose>& poses() const { return poses_; }
  [[nodiscard]] double start_s() const { return poses_.front().time_s; }
  [[nodiscard]] double end_s() const { return poses_.back().time_s; }

  static constexpr double kExtrapolation_s = 0.25;

 private:
  std::vector<TimedPose> poses_;
};

}  // namespace simuli
