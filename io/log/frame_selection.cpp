#include "io/log/frame_selection.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/log/rig_moments.hpp"

namespace simuli {
namespace {

/// Returns the poses from the first frame of a log to its last.
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

/// Returns the time at which the rig has driven `share` of its path; `key` is the setting to name in errors.
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

std::vector<std::string> sensor_names(const Log& log) {
  std::vector<std::string> names;
  for (const LogCamera& camera : log.cameras) names.push_back(camera.model.name);
  for (const LogLidar& lidar : log.lidars) names.push_back(name_of(lidar.model));
  return names;
}

std::set<std::string> known(const Log& log, const std::vector<std::string>& sensors, const std::string& key) {
  const std::vector<std::string> names = sensor_names(log);
  for (const std::string& sensor : sensors) {
    if (std::find(names.begin(), names.end(), sensor) != names.end()) continue;
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "{}: {}: found {}, allowed {}", log.folder.string(), key, sensor, fmt::join(names, ", ")));
  }
  return {sensors.begin(), sensors.end()};
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
  if (!frames.held_out_sensors.empty()) {
    texts.push_back(fmt::format("all of {}", fmt::join(frames.held_out_sensors, " and ")));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

FrameSelection nothing_held_out(FrameSelection frames) {
  frames.held_out_every = 0;
  frames.held_out_middle = 0.0;
  frames.held_out_last = 0.0;
  frames.held_out_sensors.clear();
  return frames;
}

HeldOutRule::HeldOutRule(const Log& log, const FrameSelection& frames)
    : every_(static_cast<std::size_t>(std::max(frames.held_out_every, 0))),
      counts_by_sensor_(frames.counts_by_sensor),
      sensors_(known(log, frames.held_out_sensors, "held_out_sensors")) {
  if (every_ > 0 && counts_by_sensor_) {
    RigMoments moments = rig_moments(log);
    images_ = std::move(moments.images);
    sweeps_ = std::move(moments.sweeps);
  }
  if (frames.held_out_last > 0.0) cut_s_ = time_at(log, "held_out_last", 1.0 - frames.held_out_last);
  if (frames.held_out_middle > 0.0) {
    for (const std::size_t end : {0U, 1U}) {
      const double share = 0.5 + (static_cast<double>(end) - 0.5) * frames.held_out_middle;
      middle_s_[end] = time_at(log, "held_out_middle", share);
    }
  }
}

std::vector<SensorUse> sensor_uses(const Log& log, const HeldOutRule& rule) {
  std::vector<SensorUse> uses;
  const auto add = [&](const std::string& sensor, const auto& frames, const auto& name) {
    SensorUse& of = uses.emplace_back(SensorUse{.sensor = sensor});
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (name(frames[i]) == sensor)
        ++(rule.use(i, frames[i]) == FrameUse::kTraining ? of.training : of.held_out);
    }
  };
  for (const LogCamera& c : log.cameras)
    add(c.model.name, log.images, [](const ImageFrame& f) { return f.camera; });
  for (const LogLidar& l : log.lidars)
    add(name_of(l.model), log.sweeps, [](const SweepFrame& f) { return f.lidar; });
  return uses;
}

std::vector<std::string> other_sensors(const Log& log,
                                       const std::vector<std::string>& sensors,
                                       const std::string& key) {
  const std::set<std::string> named = known(log, sensors, key);
  std::vector<std::string> others = sensor_names(log);
  std::erase_if(others, [&](const std::string& name) { return named.contains(name); });
  return others;
}

}  // namespace simuli
