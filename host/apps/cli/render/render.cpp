#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/counted.hpp"
#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/provenance.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/base/settings.hpp"
#include "host/apps/cli/base/video.hpp"
#include "host/apps/cli/render/frame_files.hpp"
#include "host/apps/cli/render/plan.hpp"
#include "host/apps/cli/render/rendered_bag.hpp"
#include "host/apps/cli/render/rendered_log.hpp"
#include "host/apps/cli/render/sensors.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/base/version.hpp"
#include "host/core/sensors/own_time.hpp"
#include "host/device/render/options/validate.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "io/base/file.hpp"
#include "io/export/frame_labels.hpp"
#include "io/export/track_labels.hpp"
#include "io/scene/frames_file.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

struct RenderCommand {
  std::string scene;
  SensorOptions sensors;
  PlanOptions plan;
  Edits edits;
  std::string output;
  FileOptions files;
  bool as_log = false;
  std::int64_t start_ns = -1;  // of a recording; negative: the log's, or usual_start_ns()
  double frames_per_s = 0.0;   // of a video; 0: from the frames' times
  std::vector<std::string> settings;
};

/// Frames per second of videos; ffmpeg and players support no other rates.
constexpr double kLeastRate = 0.01, kMostRate = 1000.0;

/// Returns the requested frame rate of a video, or the rate of the frames' times.
double frame_rate(const Plan& plan, const RenderCommand& command) {
  if (command.frames_per_s > 0.0) return command.frames_per_s;
  constexpr double kUsual = 10.0;
  if (plan.spans.size() < 2) return kUsual;
  const double seconds = plan.spans.back().time_start_s - plan.spans.front().time_start_s;
  const double rate = static_cast<double>(plan.spans.size() - 1) / seconds;
  return seconds > 0.0 ? std::clamp(rate, kLeastRate, kMostRate) : kUsual;
}

/// Returns the record of the rendered frames, without the frames.
FramesRecord record_of(const RenderCommand& command,
                       const Globals& globals,
                       const RenderOptions& options,
                       const Sensor& sensor,
                       const SceneOnDevice& scene) {
  FramesRecord record{.sensor = sensor};
  record.scene = scene.scene().name;
  record.trajectory = command.plan.trajectory;
  record.edits = lines_of(command.edits);
  if (!command.sensors.mount.empty()) record.edits.push_back("--mount " + command.sensors.mount);
  if (command.sensors.lane_shift_m != 0.0)
    record.edits.push_back(fmt::format("--lane-shift {}", command.sensors.lane_shift_m));
  if (command.files.mark_unseen) record.edits.emplace_back("--mark-unseen");
  if (command.plan.speed != 1.0) record.edits.push_back(fmt::format("--speed {}", command.plan.speed));
  record.quality = quality_names()[static_cast<std::size_t>(globals.quality)];
  record.settings = simuli::lines_of(options);
  record.version = version();
  record.device = scene.device().info().label();
  record.driver = scene.device().info().driver_version;
  return record;
}

/// Returns the views of the scene's cameras if unseen pixels are to be marked; null otherwise.
std::unique_ptr<const RecordedViews> recorded_views(const RenderCommand& command, const SceneFile& file) {
  if (!command.files.mark_unseen) return nullptr;
  auto views = std::make_unique<const RecordedViews>(file);
  if (views->empty()) {
    throw_input_error(
        command.scene, "cameras", "none that were carried along a path", "at least one, to mark unseen");
  }
  return views;
}

/// Kind of the output.
enum class OutputKind { kFolder, kFolders, kLog, kVideo, kRecording };

/// Throws Error{kUsage} for contradicting options.
OutputKind kind_of(const RenderCommand& command) {
  const std::string quoted = '"' + command.output + '"';
  const bool is_file = is_bag(command.output) || is_video(command.output);
  if (command.frames_per_s > 0.0 && !is_video(command.output))
    throw_usage_error("--fps", "with " + quoted, "with a video");
  if (command.start_ns >= 0 && !is_bag(command.output))
    throw_usage_error("--start-ns", "with " + quoted, "with an .mcap file");
  if (is_file && !command.files.labels.empty())
    throw_usage_error("--labels", "with " + quoted, "with a folder");
  if (is_bag(command.output)) {
    need_options_of_bags(command.files);
    if (command.as_log) throw_usage_error("--as-log", "with an .mcap file", "with a folder");
    return OutputKind::kRecording;
  }
  if (command.files.images == "raw") throw_usage_error("--images", "\"raw\" for a folder", "png, jpeg, exr");
  if (is_video(command.output)) {
    if (command.as_log) throw_usage_error("--as-log", "with " + quoted, "with a folder");
    const FileOptions usual;
    for (const auto& [option, value] : {std::pair("--outputs", &FileOptions::outputs),
                                        {"--values", &FileOptions::values},
                                        {"--images", &FileOptions::images},
                                        {"--clouds", &FileOptions::clouds},
                                        {"--cloud-frame", &FileOptions::cloud_frame}}) {
      if (command.files.*value != usual.*value)
        throw_usage_error(option, "with " + quoted, "with a folder: a video shows rgb");
    }
    return OutputKind::kVideo;
  }
  constexpr std::array kOtherFiles{
      ".avi", ".m4v", ".mpg", ".wmv", ".png", ".jpg", ".jpeg", ".exr", ".bag", ".db3"};
  const std::string ending = ending_of(command.output);
  if (std::find(kOtherFiles.begin(), kOtherFiles.end(), ending) != kOtherFiles.end()) {
    refuse("--output",
           command.output,
           "a folder, or a file that ends in .mp4, .mkv, .webm, .mov, .gif or .mcap");
  }
  if (command.as_log) return OutputKind::kLog;
  const bool has_many = command.sensors.names.size() != 1;
  return has_many ? OutputKind::kFolders : OutputKind::kFolder;
}

/// A sensor and its frames.
struct SensorPlan {
  Sensor sensor;
  Plan plan;
};

std::vector<SensorPlan> views_of(const Drive& drive, const SceneFile& file, const RenderCommand& command) {
  std::vector<SensorPlan> views;
  for (const RigSensor& requested : find_sensors(file, command.sensors, command.plan.duration_s)) {
    views.push_back({requested.sensor, make_plan(drive, requested, command.plan)});
  }
  return views;
}

/// Throws Error{kUsage} for options of clouds if no cloud is written.
void need_clouds(const FileOptions& files, const std::vector<SensorPlan>& views) {
  if (std::any_of(views.begin(), views.end(), [](const SensorPlan& v) { return !v.sensor.is_camera(); }))
    return;
  for (const auto& [option, is_given] : {std::pair("--clouds", files.clouds != FileOptions{}.clouds),
                                         {"--cloud-frame", !files.cloud_frame.empty()}}) {
    if (is_given) throw_usage_error(option, "with cameras alone", "with a LiDAR");
  }
}

fs::path folder_of(const SensorPlan& view, OutputKind kind, const fs::path& output) {
  return kind == OutputKind::kFolders ? output / view.sensor.name() : output;
}

/// Writes pictures or clouds, and frames.json, into an existing folder.
template <class OnFrame>
FramesRecord write_frames(SceneOnDevice& scene,
                          const SensorPlan& view,
                          const FrameFiles& files,
                          FramesRecord record,
                          const fs::path& folder,
                          const FrameSources& sources,
                          const OnFrame& on_frame) {
  files.describe(record, scene.scene());
  for (std::size_t i = 0; i < view.plan.spans.size(); ++i) {
    const Frame frame = scene.render(view.sensor, view.plan.shot(view.sensor, i), files.request());
    std::optional<Shot> next;
    if (i + 1 < view.plan.spans.size()) next = view.plan.shot(view.sensor, i + 1);
    const std::size_t number = view.plan.first + i;
    record.frames.push_back(files.write(frame,
                                        folder,
                                        fmt::format("{}_{:06d}", view.sensor.name(), number),
                                        sources,
                                        next ? &*next : nullptr));
    record.frames.back().number = number;
    on_frame();
  }
  write_frames_file(folder / "frames.json", record);
  return record;
}

/// Warns of actors for which KITTI has no class.
void warn_of_kitti(const std::vector<Actor>& actors) {
  for (const Actor& actor : actors) {
    if (has_label_class(actor.kind, LabelNames::kKitti)) continue;
    std::cerr << fmt::format(
        "simuli: {} is a \"{}\", for which KITTI has no class: written as Misc; --class {}:car sets "
        "another class\n",
        actor.name,
        actor.kind,
        actor.name);
  }
}

void write_rendered_folder(SceneOnDevice& scene,
                           const std::vector<SensorPlan>& views,
                           OutputKind kind,
                           const RenderCommand& command,
                           const RenderOptions& options,
                           const FramesRecord& record,
                           const std::shared_ptr<const SupportRecord>& seen,
                           const RecordedViews* recorded,
                           const std::function<void()>& on_frame) {
  const std::string& labels = command.files.labels;
  if (!labels.empty()) {
    std::vector<Sensor> sensors;
    for (const SensorPlan& view : views) sensors.push_back(view.sensor);
    need_label_format(labels, sensors);
    if (labels == "kitti") warn_of_kitti(scene.scene().actors);
  }
  std::vector<FrameFiles> files;
  for (const SensorPlan& view : views) files.emplace_back(command.files, view.sensor, view.plan, recorded);
  const ActorCopies copies = copies_of(command.edits);
  FrameSources sources{scene.scene(), copies};
  std::optional<SupportOnDevice> support;
  if (std::any_of(files.begin(), files.end(), [](const FrameFiles& f) { return f.needs_support(); }))
    sources.support = &support.emplace(scene.device(), seen);
  std::optional<LabelsOnDevice> labeller;
  if (!labels.empty()) sources.labels = &labeller.emplace(scene.device(), borrowed(scene.scene()), options);
  write_folder_atomically(command.output, [&](const fs::path& folder) {
    std::vector<LabelledFrames> all;
    for (std::size_t k = 0; k < views.size(); ++k) {
      const std::string name = kind == OutputKind::kFolders ? views[k].sensor.name() : "";
      const fs::path to = folder / name;
      fs::create_directories(to);
      FramesRecord own = record;
      own.sensor = views[k].sensor;
      all.push_back({name, write_frames(scene, views[k], files[k], std::move(own), to, sources, on_frame)});
    }
    if (labels == "kitti") write_kitti_labels(folder, all);
    if (labels == "coco") write_coco_labels(folder, all);
    if (labels == "nuscenes") write_nuscenes_labels(folder, all);
  });
}

void write_rendered_log(SceneOnDevice& scene,
                        const std::vector<SensorPlan>& views,
                        const RenderCommand& command,
                        const std::function<void()>& on_frame) {
  write_folder_atomically(command.output, [&](const fs::path& folder) {
    std::vector<Sensor> sensors;
    for (const SensorPlan& view : views) sensors.push_back(view.sensor);
    RenderedLog log(folder, scene.scene(), views.front().plan.world_from_rig, sensors);
    for (const SensorPlan& view : views) {
      for (std::size_t i = 0; i < view.plan.spans.size(); ++i) {
        log.add(scene.render(view.sensor, view.plan.shot(view.sensor, i)),
                view.plan.first + i,
                command.files.images);
        on_frame();
      }
    }
    log.finish();
  });
}

/// Writes the frames of all sensors in the order of their start times.
void write_rendered_bag(SceneOnDevice& scene,
                        const std::vector<SensorPlan>& views,
                        std::optional<std::int64_t> start_ns,
                        const RenderCommand& command,
                        const RecordedViews* recorded,
                        const std::function<void()>& on_frame) {
  struct Due {
    double start_s;
    const SensorPlan* view;
    std::size_t frame;
  };
  std::vector<Due> due;
  std::vector<Sensor> sensors;
  for (const SensorPlan& view : views) {
    sensors.push_back(view.sensor);
    for (std::size_t i = 0; i < view.plan.spans.size(); ++i)
      due.push_back({view.plan.spans[i].time_start_s, &view, i});
  }
  std::stable_sort(due.begin(), due.end(), [](const Due& a, const Due& b) { return a.start_s < b.start_s; });
  const Trajectory& path = views.front().plan.world_from_rig;
  if (command.start_ns >= 0) start_ns = command.start_ns;
  const Ros2Drive drive{path, sensors, scene.scene().actors, start_ns.value_or(usual_start_ns(path))};
  const FrameRequest request{.camera_median = recorded != nullptr};
  write_atomically(command.output, [&](const fs::path& file) {
    RenderedBag bag(file, drive, command.files);
    for (const Due& d : due) {
      bag.add(scene.render(d.view->sensor, d.view->plan.shot(d.view->sensor, d.frame), request), recorded);
      on_frame();
    }
    bag.finish();
  });
}

void write_video(SceneOnDevice& scene,
                 const SensorPlan& view,
                 const RenderCommand& command,
                 const RecordedViews* recorded,
                 const std::function<void()>& on_frame) {
  Video video(command.output, frame_rate(view.plan, command));
  const FrameRequest request{.camera_median = recorded != nullptr};
  for (std::size_t i = 0; i < view.plan.spans.size(); ++i) {
    video.add(shown(scene.render(view.sensor, view.plan.shot(view.sensor, i), request), recorded));
    on_frame();
  }
  video.finish();
}

void print_outcome(const RenderCommand& command,
                   OutputKind kind,
                   bool json,
                   const std::vector<SensorPlan>& views,
                   const std::string& device) {
  nlohmann::ordered_json sensors = nlohmann::ordered_json::array();
  for (const SensorPlan& view : views) {
    const std::string folder = folder_of(view, kind, command.output).string();
    const std::size_t frames = view.plan.spans.size();
    if (!json)
      std::cout << fmt::format(
          "{} of {} in {}\n", counted(frames, "frame"), view.sensor.name(), on_one_line(folder));
    sensors.push_back({{"folder", folder}, {"sensor", view.sensor.name()}, {"frames", frames}});
  }
  if (!json) return;
  const bool is_list = kind == OutputKind::kFolders || views.size() > 1;
  nlohmann::ordered_json out =
      is_list ? nlohmann::ordered_json{{"sensors", std::move(sensors)}} : std::move(sensors.front());
  out["device"] = device;
  std::cout << json_text(out) << '\n';
}

/// Whether a sensor may see part of an actor during a frame: for a camera, a corner or the centre of its box is
/// in the picture; for a LiDAR, the box is within range.
bool may_see(const Sensor& sensor, const Shot& shot, const Actor& actor) {
  if (!actor.is_there(shot.time_start_s)) return false;
  const Pose sensor_from_actor = shot.world_from_sensor_start.inverse() * actor.at(shot.time_start_s);
  if (!sensor.is_camera()) {
    const double away_m = sensor_from_actor.translation.norm() - 0.5 * actor.size_m.norm();
    return away_m < range_max(sensor.lidar());
  }
  for (int corner = 0; corner <= 8; ++corner) {
    Eigen::Vector3d p_actor = Eigen::Vector3d::Zero();
    for (int axis = 0; axis < 3 && corner < 8; ++axis) {
      p_actor(axis) = ((corner >> axis & 1) != 0 ? 0.5 : -0.5) * actor.size_m(axis);
    }
    Eigen::Vector2d pixel;
    if (sensor.camera().project(sensor_from_actor * p_actor, pixel) && is_inside(sensor.camera(), pixel))
      return true;
  }
  return false;
}

/// Warns of actors that were added by edits and are visible in no frame.
void print_unseen(const std::vector<Actor>& recorded,
                  const std::vector<Actor>& actors,
                  const std::vector<SensorPlan>& views) {
  for (const Actor& actor : actors) {
    if (has_actor(recorded, actor.name)) continue;
    const bool is_seen = std::any_of(views.begin(), views.end(), [&](const SensorPlan& view) {
      for (std::size_t i = 0; i < view.plan.spans.size(); ++i) {
        if (may_see(view.sensor, view.plan.shot(view.sensor, i), actor)) return true;
      }
      return false;
    });
    if (is_seen) continue;
    std::cerr << fmt::format(
        "simuli: note: {} is visible in none of these frames: its position is that of its track, or the "
        "start of the trajectory (--track, --move)\n",
        actor.name);
  }
}

void render(RenderCommand command, const Globals& globals) {
  const OutputKind kind = kind_of(command);
  RenderOptions options = options_of(globals.quality);
  fields_of(options).apply(command.settings);
  validate(options);
  SceneFile file = read_scene_and_report(command.scene);
  warn_unlike_training(file, options);
  const std::vector<Actor> actors_before = file.scene.actors;
  apply(command.edits, file);
  const Drive drive = read_drive(command.scene, file, command.plan);
  const std::vector<SensorPlan> views = views_of(drive, file, command);
  if (kind == OutputKind::kVideo && views.size() > 1) {
    throw_usage_error(
        "-o", fmt::format("\"{}\" for {} sensors", command.output, views.size()), "a folder, or one sensor");
  }
  need_clouds(command.files, views);
  print_unseen(actors_before, file.scene.actors, views);
  const std::unique_ptr<const RecordedViews> recorded = recorded_views(command, file);
  std::size_t frames = 0, done = 0;
  for (const SensorPlan& view : views) frames += view.plan.spans.size();

  SceneOnDevice scene(Device::best(globals.device), std::move(file.scene), options);
  FileProgress progress("render", globals);
  const auto on_frame = [&, tell = progress.callback()] { tell(++done, frames); };
  switch (kind) {
    case OutputKind::kLog:
      write_rendered_log(scene, views, command, on_frame);
      break;
    case OutputKind::kRecording:
      write_rendered_bag(scene, views, drive.start_ns, command, recorded.get(), on_frame);
      break;
    case OutputKind::kVideo:
      write_video(scene, views.front(), command, recorded.get(), on_frame);
      break;
    case OutputKind::kFolder:
    case OutputKind::kFolders:
      write_rendered_folder(scene,
                            views,
                            kind,
                            command,
                            options,
                            record_of(command, globals, options, views.front().sensor, scene),
                            file.support,
                            recorded.get(),
                            on_frame);
  }
  progress.finish();
  print_outcome(command, kind, globals.json, views, scene.device().info().label());
}

}  // namespace

void add_render(Command app, const Globals& globals) {
  const auto command = std::make_shared<RenderCommand>();
  Command sub = app.command("render",
                            "render a scene along a trajectory as its sensors or other ones see "
                            "it");
  sub.option("SCENE", command->scene, "scene folder, or splats: .ply, .spz, .glb").required();
  add_sensor_options(sub, command->sensors);
  sub.option(
         "-o,--output",
         command->output,
         "folder to write: pictures, or clouds and range pictures, and frames.json; one folder per sensor "
         "if there are several; or a video.mp4; or a ROS 2 recording, drive.mcap, by default of all "
         "sensors of the scene")
      .required();
  add_file_options(sub, command->files);
  sub.option("--fps", command->frames_per_s, "frame rate of a video; default: from the frames' times")
      .range(kLeastRate, kMostRate);
  sub.option("--start-ns",
             command->start_ns,
             "of an .mcap file: nanoseconds since 1970 of the scene's time 0; default: that of the log of "
             "--trajectory, else about a second")
      .non_negative();
  Option as_log = sub.flag("--as-log",
                           command->as_log,
                           "write the folder as a log for training, by default of all sensors of the scene");
  for (const char* other :
       {"--clouds", "--cloud-frame", "--outputs", "--values", "--fps", "--mark-unseen", "--labels"})
    as_log.excludes(other);
  add_plan_options(sub, command->plan);
  add_edit_options(sub, command->edits);
  const auto options = std::make_shared<RenderOptions>();
  const auto fields = [options, &globals] {
    *options = options_of(globals.quality);
    return fields_of(*options);
  };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.run([command, &globals] { render(*command, globals); });
}

}  // namespace simuli::cli
