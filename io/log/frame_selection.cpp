#include "io/log/frame_selection.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

/// The poses from the first frame of a log to its last.
std::vector<TimedPose> path_of_frames(const Log& log) {
  double start_s = std::numeric_limits<double>::infinity(), end_s = -start_s;
  const auto reach = [&](const auto& frames) {
    for (const auto& frame : frames) {
      start_s = std::min(start_s, frame.time_start_s);
      end_s = std::max(end_s, frame.time_end_s);
    }
  };
  reach(log.images);
  reach(log.sweeps);
  std::vector<TimedPose> path;
  if (start_s > end_s || log.world_from_rig.poses().empty()) return path;
  path.push_back({start_s, log.world_from_rig.at(start_s)});
  for (const TimedPose& pose : log.world_from_rig.poses()) {
    if (pose.time_s > start_s && pose.time_s < end_s) path.push_back(pose);
  }
  path.push_back({end_s, log.world_from_rig.at(end_s)});
  return path;
}

double step_m(const TimedPose& from, const TimedPose& to) {
  return (to.pose.translation - from.pose.translation).norm();
}

/// When the rig has that share of the path behind it; `key` asks for it.
double time_at(const Log& log, const char* key, double share) {
  const std::vector<TimedPose> path = path_of_frames(log);
  double length_m = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) length_m += step_m(path[i - 1], path[i]);
  if (!(length_m > 0.0)) {
    throw_input_error(log.folder.string(),
                      key,
                      fmt::format("a path of {} m", length_m),
                      fmt::format("one that gets somewhere, or {}=0", key));
  }
  double left_m = share * length_m;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step = step_m(path[i - 1], path[i]);
    if (step > 0.0 && left_m <= step) {
      return path[i - 1].time_s + left_m / step * (path[i].time_s - path[i - 1].time_s);
    }
    left_m -= step;
  }
  return path.back().time_s;
}

}  // namespace

std::string held_out_text(const FrameSelection& frames) {
  std::vector<std::string> texts;
  if (frames.held_out_every > 0) texts.push_back(fmt::format("every {}. frame", frames.held_out_every));
  const auto add = [&texts](const char* which, double share) {
    if (share > 0.0) texts.push_back(fmt::format("the {} {:.3g} % of the path", which, 100.0 * share));
  };
  add("middle", frames.held_out_middle);
  add("last", frames.held_out_last);
  return fmt::format("{}", fmt::join(texts, ", "));
}

FrameSelection nothing_held_out(FrameSelection frames) {
  frames.held_out_every = 0;
  frames.held_out_middle = 0.0;
  frames.held_out_last = 0.0;
  return frames;
}

HeldOutRule::HeldOutRule(const Log& log, const FrameSelection& frames)
    : every_(static_cast<std::size_t>(std::max(frames.held_out_every, 0))) {
  if (frames.held_out_last > 0.0) cut_s_ = time_at(log, "held_out_last", 1.0 - frames.held_out_last);
  if (frames.held_out_middle > 0.0) {
    for (const std::size_t end : {0U, 1U}) {
      const double share = 0.5 + (static_cast<double>(end) - 0.5) * frames.held_out_middle;
      middle_s_[end] = time_at(log, "held_out_middle", share);
    }
  }
}

}  // namespace simuli
