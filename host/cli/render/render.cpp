#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
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
#include "host/cli/base/provenance.hpp"
#include "host/cli/base/settings.hpp"
#include "host/cli/base/video.hpp"
#include "host/cli/render/frame_files.hpp"
#include "host/cli/render/plan.hpp"
#include "host/render/options/validate.hpp"
#include "host/render/scene/scene_on_device.hpp"
#include "io/base/file.hpp"
#include "io/scene/frames_file.hpp"
#include "io/scene/sensor_rig.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

struct RenderCommand {
  std::string scene;
  std::string sensor;
  PlanOptions plan;
  double lane_shift_m = 0.0;
  Edits edits;
  double scale = 1.0;
  std::string output;
  FileOptions files;
  double frames_per_s = 0.0;  // of a video; 0: as the frames follow each other
  std::vector<std::string> settings;
};

/// The sensor as asked for: pictures at --scale, frames of --duration. A LiDAR's --duration 0 is a frame's
/// (all stands still while it turns), not the LiDAR's, whose beams still fire one after the other.
Sensor find_sensor(const SceneFile& file, const RenderCommand& command) {
  Sensor sensor = SensorRig(file).find(command.sensor);
  if (sensor.is_camera()) {
    const Camera scaled = scaled_camera(sensor.camera(), command.scale);
    sensor = sensor.resized(scaled.width, scaled.height);
  }
  const bool is_told =
      command.plan.duration_s > 0.0 || (command.plan.duration_s == 0.0 && sensor.is_camera());
  return is_told ? sensor.with_duration(command.plan.duration_s) : sensor;
}

/// Frames per second of videos: others no player shows, nor does ffmpeg write them.
constexpr double kLeastRate = 0.01, kMostRate = 1000.0;

/// Of the video: as asked for, or as the frames follow each other.
double frame_rate(const Plan& plan, const RenderCommand& command) {
  if (command.frames_per_s > 0.0) return command.frames_per_s;
  constexpr double kUsual = 10.0;
  if (plan.spans.size() < 2) return kUsual;
  const double seconds = plan.spans.back().time_start_s - plan.spans.front().time_start_s;
  const double rate = static_cast<double>(plan.spans.size() - 1) / seconds;
  return seconds > 0.0 ? std::clamp(rate, kLeastRate, kMostRate) : kUsual;
}

/// All but the frames.
FramesRecord record_of(const RenderCommand& command,
                       const Globals& globals,
                       const RenderOptions& options,
                       const Sensor& sensor,
                       const SceneOnDevice& scene) {
  FramesRecord record{.sensor = sensor};
  record.scene = scene.scene().name;
  record.trajectory = command.plan.trajectory;
  record.edits = lines_of(command.edits);
  if (command.lane_shift_m != 0.0)
    record.edits.push_back(fmt::format("--lane-shift {}", command.lane_shift_m));
  if (command.plan.speed != 1.0) record.edits.push_back(fmt::format("--speed {}", command.plan.speed));
  record.quality = quality_names()[static_cast<std::size_t>(globals.quality)];
  record.settings = simuli::lines_of(options);
  record.version = version();
  record.device = scene.device().info().label();
  record.driver = scene.device().info().driver_version;
  return record;
}

void render(const RenderCommand& command, const Globals& globals) {
  if (is_video(command.output) && command.files.outputs != FileOptions{}.outputs) {
    throw Error(ErrorKind::kUsage,
                fmt::format("--outputs: found with \"{}\", allowed with a folder: a video shows rgb",
                            command.output));
  }
  RenderOptions options = options_of(globals.quality);
  fields_of(options).apply(command.settings);
  validate(options);
  SceneFile file = read_scene(command.scene);
  warn_unlike_training(file, options);
  apply(command.edits, file);
  const Pose rig_from_shifted{Eigen::Quaterniond::Identity(), {0.0, command.lane_shift_m, 0.0}};
  Sensor sensor = find_sensor(file, command);
  sensor = sensor.mounted(rig_from_shifted * sensor.rig_from_sensor());
  const Plan plan = make_plan(command.scene, file, command.sensor, sensor, command.plan);

  SceneOnDevice scene(Device::best(globals.device), std::move(file.scene), options);
  FileProgress progress("render", globals);
  const auto on_frame = progress.callback();
  const auto run = [&](const FrameRequest& request, const auto& use) {
    for (std::size_t i = 0; i < plan.spans.size(); ++i) {
      use(i, scene.render(sensor, plan.shot(sensor, i), request));
      on_frame(i + 1, plan.spans.size());
    }
  };
  if (is_video(command.output)) {
    Video video(command.output, frame_rate(plan, command));
    run({}, [&](std::size_t, const Frame& frame) { video.add(shown(frame)); });
    video.finish();
  } else {
    const FrameFiles files(command.files, sensor, plan);
    FramesRecord record = record_of(command, globals, options, sensor, scene);
    files.describe(record, scene.scene());
    write_folder_atomically(command.output, [&](const fs::path& folder) {
      run(files.request(), [&](std::size_t i, const Frame& frame) {
        const Shot& shot = frame.shot();
        record.frames.push_back(
            {files.write(frame, folder, fmt::format("{}_{:06d}", sensor.name(), plan.first + i)),
             shot.time_start_s,
             shot.time_end_s,
             shot.world_from_sensor_start,
             shot.world_from_sensor_end});
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
  sub.option("SCENE", command->scene, "scene folder, or splats: .ply, .spz").required();
  sub.option("--sensor",
             command->sensor,
             "a sensor of the scene; or a built-in camera or LiDAR, or one of a file, in its place")
      .required();
  sub.option("-o,--output",
             command->output,
             "folder to make: pictures, or clouds and range pictures, and frames.json; or a video.mp4")
      .required();
  add_file_options(sub, command->files);
  sub.option("--fps", command->frames_per_s, "of a video; default: as the frames follow each other")
      .range(kLeastRate, kMostRate);
  add_plan_options(sub, command->plan);
  sub.option("--lane-shift", command->lane_shift_m, "move the rig to its left, m");
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
