#include "host/apps/cli/render/plan.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "host/apps/cli/base/numbers.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/error.hpp"
#include "io/log/log.hpp"

namespace simuli::cli {
namespace {

constexpr char kRecorded[] = "recorded";

/// Returns the duration of a frame that was not recorded.
double duration_of(const Sensor& sensor, const PlanOptions& options) {
  if (options.duration_s >= 0.0) return options.duration_s;
  const bool is_known =
      !sensor.is_camera() || sensor.camera().shutter == ShutterKind::kGlobal || sensor.duration_s() > 0.0;
  if (is_known) return sensor.duration_s();
  refuse("--duration",
         "",
         "the read-out time in s, as camera " + sensor.camera().name + " has a rolling shutter");
}

std::vector<FrameSpan> spans_at(const std::vector<double>& starts_s, double duration_s) {
  std::vector<FrameSpan> spans;
  for (const double t : starts_s) spans.push_back({t, t + duration_s});
  return spans;
}

std::vector<double> parse_times(const std::string& text) {
  constexpr double kMostFrames = 1e6;
  const std::vector<double> t = parse_numbers("--times", text, 3, ':');
  const double steps = (t[1] - t[0]) / t[2];
  const bool allowed = t[2] > 0.0 && t[1] >= t[0] && steps < kMostFrames;
  if (!allowed) refuse("--times", text, "t0:t1:dt with t0 <= t1, dt > 0 and less than a million frames");
  std::vector<double> times;
  // A small fraction of a step, so that 0:1:0.1 includes 1.
  for (int i = 0; i <= steps + 1e-6; ++i) times.push_back(t[0] + i * t[2]);
  return times;
}

/// Returns the recorded times of a sensor's frames. Options of another sensor and --duration take precedence.
std::vector<FrameSpan> recorded_spans(const SensorRig& recorded,
                                      const RigSensor& requested,
                                      const PlanOptions& options) {
  std::vector<FrameSpan> spans = recorded.frames(requested.model, requested.sensor);
  if (spans.empty() || (recorded.has(requested.model) && options.duration_s < 0.0)) return spans;
  const double duration_s = duration_of(requested.sensor, options);
  for (FrameSpan& span : spans) span.time_end_s = span.time_start_s + duration_s;
  return spans;
}

/// Keeps the spans that --frames selects.
void select_spans(Plan& plan, const std::string& frames) {
  if (frames.empty()) return;
  const std::vector<FrameSpan> all = plan.spans;
  const bool is_one = frames.find(':') == std::string::npos;
  const std::string allowed_text = fmt::format("a or a:b with 0 <= a <= b < {}", all.size());
  const std::vector<double> range =
      parse_numbers("--frames", is_one ? frames + ':' + frames : frames, 2, ':', allowed_text);
  const double a = range[0], b = range[1];
  const bool allowed =
      a >= 0.0 && b >= a && b < static_cast<double>(all.size()) && a == std::floor(a) && b == std::floor(b);
  if (!allowed) refuse("--frames", frames, allowed_text);
  const auto first = all.begin() + static_cast<std::ptrdiff_t>(a);
  plan.spans = {first, first + static_cast<std::ptrdiff_t>(b - a) + 1};
  plan.first = static_cast<std::size_t>(a);
}

/// Returns the trajectory driven `rate` times as fast, from the same start.
Trajectory driven(const Trajectory& path, double rate) {
  std::vector<TimedPose> poses = path.poses();
  const double start_s = path.start_s();
  for (TimedPose& pose : poses) pose.time_s = start_s + (pose.time_s - start_s) / rate;
  return Trajectory(std::move(poses));
}

/// Returns the frames that end before the trajectory does.
std::vector<FrameSpan> spans_within(const std::vector<FrameSpan>& spans, const Trajectory& path) {
  std::vector<FrameSpan> within;
  for (const FrameSpan& span : spans) {
    if (span.time_end_s <= path.end_s() + Trajectory::kExtrapolation_s) within.push_back(span);
  }
  return within;
}

}  // namespace

void add_plan_options(Command sub, PlanOptions& options) {
  sub.option("--trajectory", options.trajectory, "recorded: the scene's own, or a log folder").with_default();
  sub.option(
      "--times", options.times, "t0:t1:dt, frame starts in s of the log; default: the recorded frames");
  sub.option("--frames",
             options.frames,
             "a:b, first and last of the sensor's recorded frames, counted from 0; a: "
             "one frame");
  sub.option("--duration", options.duration_s, "of one frame, s; default: as recorded, or the sensor's")
      .non_negative();
  sub.option("--speed", options.speed, "factor on the recorded speed along the trajectory")
      .range(0.01, 100.0);
}

Shot Plan::shot(const Sensor& sensor, std::size_t i) const {
  return Shot::along(world_from_rig, sensor.rig_from_sensor(), spans[i].time_start_s, spans[i].time_end_s);
}

Drive read_drive(const std::string& scene, const SceneFile& file, const PlanOptions& options) {
  if (options.trajectory != kRecorded) {
    const Log log = read_log(options.trajectory);
    return {options.trajectory, log.world_from_rig, SensorRig(log), log.start_ns};
  }
  if (file.world_from_rig.poses().empty()) {
    throw_input_error(scene, "trajectory", "no poses", "at least one, or --trajectory LOG");
  }
  return {scene, file.world_from_rig, SensorRig(file)};
}

Plan make_plan(const Drive& drive, const RigSensor& requested, const PlanOptions& options) {
  if (!options.times.empty() && !options.frames.empty()) {
    refuse("--frames", options.frames, "either --times or --frames");
  }
  const std::vector<double> times =
      options.times.empty() ? std::vector<double>{} : parse_times(options.times);
  Plan plan;
  plan.world_from_rig = drive.world_from_rig;
  std::vector<FrameSpan> recorded;
  if (times.empty()) {
    recorded = recorded_spans(drive.recorded, requested, options);
    if (recorded.empty()) {
      throw_input_error(
          drive.source,
          "recorded_frames of " + requested.sensor.name(),
          options.trajectory == kRecorded ? "none (a scene of an older version has none)" : "none",
          "at least one, or --times, or another --trajectory LOG");
    }
  }
  if (options.speed != 1.0) {
    plan.world_from_rig = driven(plan.world_from_rig, options.speed);
    recorded = spans_within(recorded, plan.world_from_rig);
  }
  plan.spans = times.empty() ? std::move(recorded) : spans_at(times, duration_of(requested.sensor, options));
  select_spans(plan, options.frames);
  return plan;
}

}  // namespace simuli::cli
