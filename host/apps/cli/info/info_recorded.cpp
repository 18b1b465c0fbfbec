// Times of recordings and distances of actors.
#include <algorithm>
#include <utility>

#include "host/apps/cli/info/info.hpp"
#include "host/core/base/spread.hpp"

namespace simuli::cli {

Recorded recorded_of(const std::vector<FrameSpan>& spans) {
  Recorded recorded{.frames = spans.size()};
  if (spans.empty()) return recorded;
  recorded.start_s = spans.front().time_start_s;
  recorded.end_s = spans.back().time_end_s;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < spans.size(); ++i) {
    steps_s.push_back(spans[i].time_start_s - spans[i - 1].time_start_s);
  }
  const double step_s = upper_median(std::move(steps_s));
  if (step_s > 0.0) recorded.rate_hz = 1.0 / step_s;
  return recorded;
}

Approach nearest_approach(const Actor& actor, const Trajectory& world_from_rig) {
  Approach nearest;
  if (world_from_rig.poses().empty()) return nearest;
  const auto visit = [&](double time_s) {
    if (time_s < world_from_rig.start_s() || time_s > world_from_rig.end_s() || !actor.is_there(time_s))
      return;
    const double distance_m = (actor.at(time_s).translation - world_from_rig.at(time_s).translation).norm();
    if (nearest.is_found && distance_m >= nearest.distance_m) return;
    nearest = {true, distance_m, time_s};
  };
  // Both move linearly between their poses, which are a fraction of a second apart.
  for (const KeyPose& key : actor.track) visit(key.time_s);
  for (const TimedPose& pose : world_from_rig.poses()) visit(pose.time_s);
  return nearest;
}

ActorFrames frames_with(const Actor& actor, const Log& log) {
  const auto is_there = [&](const auto& frame) {
    return actor.is_there(0.5 * (frame.time_start_s + frame.time_end_s));
  };
  const auto count = [&](const auto& frames) {
    return static_cast<std::size_t>(std::count_if(frames.begin(), frames.end(), is_there));
  };
  return {count(log.images), count(log.sweeps)};
}

}  // namespace simuli::cli
