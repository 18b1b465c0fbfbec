#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
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
#include "host/cli/render/plan.hpp"
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

struct RenderCommand {
  std::string scene;
  std::string sensor;
  PlanOptions plan;
  double lane_shift_m = 0.0;
  Edits edits;
  double scale = 1.0;
  std::string output;
  std::string images = "png";
  std::string clouds = "ply";
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

/// Renders the plan's frames one after the other: use(frame index, picture) gets a camera's picture or a
/// LiDAR's ranges as one, and clouds(index, points) the returns.
template <class Use, class UseCloud>
void render_plan(
    SceneOnDevice& scene, const Sensor& sensor, const Plan& plan, const Use& use, const UseCloud& use_cloud) {
  for (std::size_t i = 0; i < plan.spans.size(); ++i) {
    const Frame frame = scene.render(sensor, plan.shot(sensor, i));
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
      const Shot shot = plan.shot(sensor, i);
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
  sub.option("SCENE", command->scene, "scene folder, or splats: .ply, .spz").required();
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
