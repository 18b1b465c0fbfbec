#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/version.hpp"
#include "host/cli/base/commands.hpp"
#include "host/cli/base/edits.hpp"
#include "host/cli/base/file_progress.hpp"
#include "host/cli/base/json_text.hpp"
#include "host/cli/base/pictures.hpp"
#include "host/cli/base/provenance.hpp"
#include "host/cli/base/settings.hpp"
#include "host/cli/base/video.hpp"
#include "host/render/options/validate.hpp"
#include "host/render/scene/scene_on_device.hpp"
#include "io/base/file.hpp"
#include "io/scene/frames_file.hpp"
#include "io/scene/sensor_rig.hpp"
#include "io/splat/cloud_file.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

constexpr char kRecorded[] = "recorded";

struct RenderCommand {
  std::string scene;
  std::string sensor;
  std::string trajectory = kRecorded;
  std::string times;         // t0:t1:dt, s
  std::string frames;        // a:b
  double duration_s = -1.0;  // of one frame; below 0: as the sensor says
  double lane_shift_m = 0.0;
  double speed = 1.0;  // of the rig over the recorded
  Edits edits;
  double scale = 1.0;
  std::string output;
  std::string images = "png";
  std::string clouds = "ply";
  double frames_per_s = 0.0;  // of a video; 0: as the frames follow each other
  std::vector<std::string> settings;
};

struct Span {
  double start_s = 0.0;
  double end_s = 0.0;
};

[[noreturn]] void refuse(const std::string& what, const std::string& found, const std::string& allowed) {
  throw Error(ErrorKind::kUsage, fmt::format("{}: found \"{}\", allowed {}", what, found, allowed));
}

/// The sensor as asked for: pictures at --scale, frames of --duration. A LiDAR's --duration 0 is a frame's
/// (all stands still while it turns), not the LiDAR's, whose beams still fire one after the other.
Sensor find_sensor(const SceneFile& file, const RenderCommand& command) {
  Sensor sensor = SensorRig(file).find(command.sensor);
  if (sensor.is_camera()) {
    const Camera scaled = scaled_camera(sensor.camera(), command.scale);
    sensor = sensor.resized(scaled.width, scaled.height);
  }
  const bool is_told = command.duration_s > 0.0 || (command.duration_s == 0.0 && sensor.is_camera());
  return is_told ? sensor.with_duration(command.duration_s) : sensor;
}

/// "a:b:c" as `count` numbers.
std::vector<double> parse_numbers(const char* option, const std::string& text, std::size_t count) {
  std::vector<double> values;
  const char* at = text.data();
  const char* end = at + text.size();
  while (values.size() < count) {
    double value = 0.0;
    const auto result = std::from_chars(at, end, value);
    if (result.ec != std::errc{} || !std::isfinite(value)) break;
    values.push_back(value);
    at = result.ptr;
    if (values.size() == count && at == end) return values;
    if (at == end || *at != ':') break;
    ++at;
  }
  refuse(option, text, fmt::format("{} finite numbers parted by ':'", count));
}

/// How long one frame takes when it is not a recorded one.
double duration_of(const Sensor& sensor, const RenderCommand& command) {
  if (command.duration_s >= 0.0) return command.duration_s;
  const bool is_known =
      !sensor.is_camera() || sensor.camera().shutter == ShutterKind::kGlobal || sensor.duration_s() > 0.0;
  if (is_known) return sensor.duration_s();
  refuse("--duration",
         "",
         "the read-out time in s, as camera " + sensor.camera().name + " has a rolling shutter");
}

std::vector<Span> spans_at(const std::vector<double>& starts_s, double duration_s) {
  std::vector<Span> spans;
  for (const double t : starts_s) spans.push_back({t, t + duration_s});
  return spans;
}

std::vector<double> parse_times(const std::string& text) {
  constexpr double kMostFrames = 1e6;
  const std::vector<double> t = parse_numbers("--times", text, 3);
  const double steps = (t[1] - t[0]) / t[2];
  const bool allowed = t[2] > 0.0 && t[1] >= t[0] && steps < kMostFrames;
  if (!allowed) refuse("--times", text, "t0:t1:dt with t0 <= t1, dt > 0 and less than a million frames");
  std::vector<double> times;
  // A hair more of a step, so that 0:1:0.1 includes 1.
  for (int i = 0; i <= steps + 1e-6; ++i) times.push_back(t[0] + i * t[2]);
  return times;
}

/// Times of the log's frames of this sensor, or the starts of those of the log's first LiDAR.
/// What a LiDAR takes that the log does not have: `duration_s`.
std::vector<Span> recorded_spans(const Log& log, const Sensor& sensor, double duration_s) {
  std::vector<Span> spans;
  if (sensor.is_camera()) {
    for (const ImageFrame& f : log.images) {
      if (f.camera == sensor.camera().name) spans.push_back({f.time_start_s, f.time_end_s});
    }
  } else if (!log.lidars.empty()) {
    const std::string& own = name_of(sensor.lidar());
    const bool is_there = std::any_of(
        log.lidars.begin(), log.lidars.end(), [&](const LogLidar& l) { return name_of(l.model) == own; });
    const std::string& name = is_there ? own : name_of(log.lidars.front().model);
    for (const SweepFrame& f : log.sweeps) {
      if (f.lidar != name) continue;
      spans.push_back({f.time_start_s, is_there ? f.time_end_s : f.time_start_s + duration_s});
    }
  }
  return spans;
}

struct Plan {
  Trajectory world_from_rig;
  std::vector<Span> spans;
  std::size_t first = 0;  // number of the first span's frame
};

/// Makes them those that --frames asks for.
void select_spans(Plan& plan, const std::string& frames) {
  if (frames.empty()) return;
  const std::vector<Span> all = plan.spans;
  const std::vector<double> range = parse_numbers("--frames", frames, 2);
  const double a = range[0], b = range[1];
  const bool allowed =
      a >= 0.0 && b >= a && b < static_cast<double>(all.size()) && a == std::floor(a) && b == std::floor(b);
  if (!allowed) refuse("--frames", frames, fmt::format("a:b with 0 <= a <= b < {}", all.size()));
  const auto first = all.begin() + static_cast<std::ptrdiff_t>(a);
  plan.spans = {first, first + static_cast<std::ptrdiff_t>(b - a) + 1};
  plan.first = static_cast<std::size_t>(a);
}

/// The same path `rate` times as fast from its start on.
Trajectory driven(const Trajectory& path, double rate) {
  std::vector<TimedPose> poses = path.poses();
  const double start_s = path.start_s();
  for (TimedPose& pose : poses) pose.time_s = start_s + (pose.time_s - start_s) / rate;
  return Trajectory(std::move(poses));
}

/// Frames that end before the path does.
std::vector<Span> spans_within(const std::vector<Span>& spans, const Trajectory& path) {
  std::vector<Span> within;
  for (const Span& span : spans) {
    if (span.end_s <= path.end_s() + Trajectory::kExtrapolation_s) within.push_back(span);
  }
  return within;
}

Plan make_plan(const SceneFile& file, const Sensor& sensor, const RenderCommand& command) {
  if (!command.times.empty() && !command.frames.empty()) {
    refuse("--frames", command.frames, "either --times or --frames");
  }
  const std::vector<double> times =
      command.times.empty() ? std::vector<double>{} : parse_times(command.times);
  Plan plan;
  std::vector<Span> recorded;
  if (command.trajectory == kRecorded) {
    plan.world_from_rig = file.world_from_rig;
    if (plan.world_from_rig.poses().empty()) {
      throw_input_error(command.scene, "trajectory", "no poses", "at least one, or --trajectory LOG");
    }
    if (times.empty()) {
      std::vector<double> starts_s;
      for (const TimedPose& p : plan.world_from_rig.poses()) starts_s.push_back(p.time_s);
      recorded = spans_at(starts_s, duration_of(sensor, command));
    }
  } else {
    const Log log = read_log(command.trajectory);
    plan.world_from_rig = log.world_from_rig;
    recorded =
        recorded_spans(log, sensor, command.duration_s < 0.0 ? sensor.duration_s() : command.duration_s);
    if (times.empty() && recorded.empty()) {
      throw_input_error(
          command.trajectory, "frames of " + command.sensor, "none", "at least one, or --times");
    }
  }
  if (command.speed != 1.0) {
    plan.world_from_rig = driven(plan.world_from_rig, command.speed);
    recorded = spans_within(recorded, plan.world_from_rig);
  }
  plan.spans = times.empty() ? std::move(recorded) : spans_at(times, duration_of(sensor, command));
  select_spans(plan, command.frames);
  return plan;
}

Shot shot_of(const Plan& plan, const Sensor& sensor, std::size_t i) {
  return Shot::along(
      plan.world_from_rig, sensor.rig_from_sensor(), plan.spans[i].start_s, plan.spans[i].end_s);
}

/// Renders the plan's frames one after the other: use(frame index, picture) gets a camera's picture or a
/// LiDAR's ranges as one, and clouds(index, points) the returns.
template <class Use, class UseCloud>
void render_plan(
    SceneOnDevice& scene, const Sensor& sensor, const Plan& plan, const Use& use, const UseCloud& use_cloud) {
  for (std::size_t i = 0; i < plan.spans.size(); ++i) {
    const Frame frame = scene.render(sensor, shot_of(plan, sensor, i));
    if (sensor.is_camera()) {
      use(i, frame.image());
    } else {
      use_cloud(i, point_cloud(frame));
      const LidarFrame sweep = frame.lidar();
      use(i, range_image(sensor.lidar(), sweep.rays, sweep.range));
    }
  }
}

/// Frames per second of videos: others no player shows, nor does ffmpeg write them.
constexpr double kLeastRate = 0.01, kMostRate = 1000.0;

/// Of the video: as asked for, or as the frames follow each other.
double frame_rate(const Plan& plan, const RenderCommand& command) {
  if (command.frames_per_s > 0.0) return command.frames_per_s;
  constexpr double kUsual = 10.0;
  if (plan.spans.size() < 2) return kUsual;
  const double seconds = plan.spans.back().start_s - plan.spans.front().start_s;
  const double rate = static_cast<double>(plan.spans.size() - 1) / seconds;
  return seconds > 0.0 ? std::clamp(rate, kLeastRate, kMostRate) : kUsual;
}

/// Float holds a millimetre up to here.
constexpr double kFarthestFloat_m = 8192.0;

void warn_of_rounding(const Plan& plan, const Sensor& sensor) {
  if (sensor.is_camera()) return;
  double farthest_m = 0.0;
  for (const TimedPose& p : plan.world_from_rig.poses()) {
    farthest_m = std::max(farthest_m, p.pose.translation.norm());
  }
  if (farthest_m <= kFarthestFloat_m) return;
  std::cerr << fmt::format(
      "simuli: warning: {:.0f} m from the world's origin the float coordinates of points step by {:.3g} m\n",
      farthest_m,
      farthest_m * std::numeric_limits<float>::epsilon());
}

/// All but the frames.
FramesRecord record_of(const RenderCommand& command,
                       const Globals& globals,
                       const RenderOptions& options,
                       const Sensor& sensor,
                       const SceneOnDevice& scene) {
  FramesRecord record{.sensor = sensor};
  record.scene = scene.scene().name;
  record.trajectory = command.trajectory;
  record.edits = lines_of(command.edits);
  if (command.lane_shift_m != 0.0)
    record.edits.push_back(fmt::format("--lane-shift {}", command.lane_shift_m));
  if (command.speed != 1.0) record.edits.push_back(fmt::format("--speed {}", command.speed));
  record.quality = quality_names()[static_cast<std::size_t>(globals.quality)];
  record.settings = simuli::lines_of(options);
  record.version = version();
  record.device = scene.device().info().label();
  record.driver = scene.device().info().driver_version;
  return record;
}

void render(const RenderCommand& command, const Globals& globals) {
  RenderOptions options = options_of(globals.quality);
  fields_of(options).apply(command.settings);
  validate(options);
  SceneFile file = read_scene(command.scene);
  warn_unlike_training(file, options);
  apply(command.edits, file.scene);
  const Pose rig_from_shifted{Eigen::Quaterniond::Identity(), {0.0, command.lane_shift_m, 0.0}};
  Sensor sensor = find_sensor(file, command);
  sensor = sensor.mounted(rig_from_shifted * sensor.rig_from_sensor());
  const Plan plan = make_plan(file, sensor, command);
  warn_of_rounding(plan, sensor);

  SceneOnDevice scene(Device::best(globals.device), std::move(file.scene), options);
  FileProgress progress("render", globals);
  const auto on_frame = progress.callback();
  const auto run = [&](const auto& use, const auto& use_cloud) {
    render_plan(
        scene,
        sensor,
        plan,
        [&](std::size_t i, const Image& image) {
          use(i, image);
          on_frame(i + 1, plan.spans.size());
        },
        use_cloud);
  };
  if (is_video(command.output)) {
    Video video(command.output, frame_rate(plan, command));
    run([&](std::size_t, const Image& image) { video.add(image); }, [](std::size_t, const PointCloud&) {});
    video.finish();
  } else {
    FramesRecord record = record_of(command, globals, options, sensor, scene);
    for (std::size_t i = 0; i < plan.spans.size(); ++i) {
      const Shot shot = shot_of(plan, sensor, i);
      record.frames.push_back(
          {{}, shot.time_start_s, shot.time_end_s, shot.world_from_sensor_start, shot.world_from_sensor_end});
    }
    write_folder_atomically(command.output, [&](const fs::path& folder) {
      const auto name = [&](std::size_t i, const std::string& ending) {
        record.frames[i].files.push_back(fmt::format("{}_{:06d}{}", sensor.name(), plan.first + i, ending));
        return folder / record.frames[i].files.back();
      };
      run(
          [&](std::size_t i, const Image& image) {
            write_image(name(i, sensor.is_camera() ? "." + command.images : "_range.png"), image);
          },
          [&](std::size_t i, const PointCloud& cloud) {
            write_point_cloud(name(i, "." + command.clouds), cloud);
          });
      write_frames_file(folder / "frames.json", record);
    });
  }
  progress.finish();
  if (globals.json) {
    const nlohmann::ordered_json out = {{"folder", command.output},
                                        {"sensor", sensor.name()},
                                        {"frames", plan.spans.size()},
                                        {"device", scene.device().info().label()}};
    std::cout << json_text(out) << '\n';
  } else {
    std::cout << fmt::format("{} frames of {} in {}\n", plan.spans.size(), sensor.name(), command.output);
  }
}

}  // namespace

void add_render(Command app, const Globals& globals) {
  const auto command = std::make_shared<RenderCommand>();
  Command sub = app.command("render", "what a sensor sees of a scene along a trajectory");
  sub.option("SCENE", command->scene, "scene folder").required();
  sub.option("--sensor",
             command->sensor,
             "a sensor of the scene; or a built-in camera or LiDAR, or one of a file, in its place")
      .required();
  sub.option("-o,--output",
             command->output,
             "folder to make: pictures, or clouds and range pictures, and frames.json; or a video.mp4")
      .required();
  sub.option("--images", command->images, "png, or exr with float colours")
      .one_of({"png", "exr"})
      .with_default();
  sub.option("--clouds", command->clouds, "ply, pcd or npz").one_of({"ply", "pcd", "npz"}).with_default();
  sub.option("--fps", command->frames_per_s, "of a video; default: as the frames follow each other")
      .range(kLeastRate, kMostRate);
  sub.option("--trajectory", command->trajectory, "recorded: the scene's own, or a log folder")
      .with_default();
  sub.option("--times", command->times, "t0:t1:dt, frame starts in s; default: all that was recorded");
  sub.option("--frames", command->frames, "a:b, first and last of the recorded frames, from 0");
  sub.option("--duration", command->duration_s, "of one frame, s; default: as the LiDAR says; 0 for cameras")
      .non_negative();
  sub.option("--lane-shift", command->lane_shift_m, "move the rig to its left, m");
  sub.option("--speed", command->speed, "drive the path this many times as fast as recorded")
      .range(0.01, 100.0);
  add_edit_options(sub, command->edits);
  sub.option("--scale", command->scale, "size of the pictures over the camera's own");
  const auto options = std::make_shared<RenderOptions>();
  const auto fields = [options, &globals] {
    *options = options_of(globals.quality);
    return fields_of(*options);
  };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.run([command, &globals] { render(*command, globals); });
}

}  // namespace simuli::cli
