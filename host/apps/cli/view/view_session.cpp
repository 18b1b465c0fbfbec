#include "host/apps/cli/view/view_session.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/draw/pictures.hpp"
#include "host/apps/cli/view/view_layers.hpp"
#include "host/apps/cli/view/view_parts.hpp"
#include "host/core/base/activity.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/stopwatch.hpp"
#include "host/core/scene/edit.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "host/device/render/options/quality.hpp"
#include "io/base/json_reader.hpp"
#include "io/picture/image.hpp"
#include "io/scene/splat_scene.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli::cli {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

RenderOptions options_named(const std::string& quality) {
  const std::optional<Quality> known = find_quality(quality);
  if (known) return options_of(*known);
  refuse("quality", quality, fmt::format("{}", fmt::join(quality_names(), ", ")));
}

/// Left is a rotation about the camera's -y axis (up), down about its x axis.
Pose camera_from_turned(const ViewRequest& request) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(-request.yaw_rad, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(-request.pitch_rad, Eigen::Vector3d::UnitX())),
          Eigen::Vector3d::Zero()};
}

/// Returns `wanted`, with a number appended if the scene has an actor of that name.
std::string new_name(const Scene& scene, const std::string& wanted) {
  std::string name = wanted;
  for (int i = 2; has_actor(scene.actors, name); ++i) name = fmt::format("{}_{}", wanted, i);
  return name;
}

}  // namespace

ViewSession::ViewSession(const Globals& globals, SceneFile file, ViewSource source)
    : globals_(globals),
      file_(std::move(file)),
      recorded_(file_),
      rig_(file_),
      scene_(Device::best(globals.device), std::move(file_.scene)),
      copies_(copies_of(source.edits)),
      source_(std::move(source)),
      requested_s_(-std::numeric_limits<double>::infinity()) {
  rig_.refuse_files();
}

void ViewSession::show(Scene scene) {
  {
    const std::lock_guard lock(mutex_);
    scene_.set_scene(std::move(scene));
  }
  const std::lock_guard lock(progress_mutex_);
  ++version_;
}

void ViewSession::set_progress(const ViewProgress& progress) {
  const std::lock_guard lock(progress_mutex_);
  progress_ = progress;
}

double ViewSession::idle_s() const {
  const std::lock_guard lock(progress_mutex_);
  return now_s() - requested_s_;
}

void ViewSession::touch() {
  const std::lock_guard lock(progress_mutex_);
  requested_s_ = now_s();
}

std::string ViewSession::describe() const {
  const std::lock_guard lock(mutex_);
  const Scene& scene = scene_.scene();
  Json out =
      json_of_drive(file_.cameras, file_.lidars, file_.world_from_rig, file_.recorded_frames, scene.origin);
  out["kind"] = "scene";
  out["name"] = scene.name;
  out["device"] = scene_.device().info().label();
  out["builtin_cameras"] = builtin_camera_names();
  out["builtin_lidars"] = builtin_lidar_names();
  out["qualities"] = quality_names();
  out["quality"] = quality_names().at(static_cast<std::size_t>(globals_.quality));
  out["has_support"] = file_.support != nullptr;
  out["depth_colours"] = Json::array();  // colour scale of the depth layer, from near to far
  for (int i = 0; i <= 8; ++i) out["depth_colours"].push_back(colour_at(i / 8.0));
  out["added"] = added_names_;
  out["actors"] = json_of_actors(scene.actors);
  return out.dump();
}

std::string ViewSession::progress() const {
  const std::lock_guard lock(progress_mutex_);
  const TrainStatus& s = progress_.status;
  const Json out = {{"version", version_},
                    {"activity", Activity::now()},
                    {"training", progress_.training},
                    {"iteration", s.iteration},
                    {"iterations", progress_.iterations},
                    {"psnr_db", s.psnr_db},  // null unless finite
                    {"distance_m", s.distance_m},
                    {"camera_particles", s.camera_particles},
                    {"lidar_particles", s.lidar_particles}};
  return out.dump();
}

void ViewSession::change(const std::function<std::string(Scene&)>& how) {
  {
    const std::lock_guard lock(progress_mutex_);
    if (progress_.training) {
      throw_usage_error("scene", "one that is being trained", "a finished one");
    }
  }
  const std::lock_guard lock(mutex_);
  if (added_.size() == kMostAdded) {
    throw_usage_error("actors", fmt::format("{} that were added", added_.size()), "no more");
  }
  Scene scene = scene_.scene();
  const std::string option = how(scene);
  const std::string name = scene.actors.back().name;
  scene_.set_scene(std::move(scene));
  added_.push_back(option);
  added_names_.push_back(name);
  const std::lock_guard progress_lock(progress_mutex_);
  ++version_;
}

std::string ViewSession::duplicate(const std::string& json) {
  const std::string name = read_json_text(json, "request", [](JsonObject& o) { return o.text("actor"); });
  std::string copy;
  change([&](Scene& scene) {
    copy = new_name(scene, name);
    duplicate_actor(scene, name, copy);
    add_copy(copies_, name, copy);
    return fmt::format("--duplicate {}:{}", name, copy);
  });
  return Json{{"actor", copy}}.dump();
}

std::string ViewSession::add(const std::string& file_name, const std::string& bytes, double time_s) {
  const std::filesystem::path file = name_from(file_name);
  if (!is_splat_file(file)) throw_input_error(file.string(), "extension", "another one", kSplatExtensions);
  SplatReport report;
  const Scene object = scene_of_splats(read_splats(bytes, file, &report), file).scene;
  const Trajectory& path = file_.world_from_rig;
  const double at_s = std::clamp(time_s, path.start_s(), path.end_s());
  const Pose base_from_rig = standing_pose(path).inverse() * path.at(at_s);
  constexpr double kAhead_m = 10.0;
  Eigen::Vector3d moved_m = base_from_rig * Eigen::Vector3d(kAhead_m, 0.0, 0.0);
  moved_m.z() = base_from_rig.translation.z();
  std::string name;
  change([&](Scene& scene) {
    name = new_name(scene, name_from(file.stem().stem().string()));
    add_actor(scene, as_actor(object, name, standing_pose(path)), name, name);
    return fmt::format("--add {}:{}", file.string(), name);
  });
  return Json{{"actor", name}, {"moved_m", json_of(moved_m)}, {"notes", report.notes()}}.dump();
}

std::string ViewSession::command(const ViewRequest& request) const {
  if (source_.scene.empty()) {
    throw_usage_error("command", "a scene that is being trained", "one on disk");
  }
  const std::lock_guard lock(mutex_);
  const Trajectory& path = file_.world_from_rig;
  const double time_s = std::clamp(request.time_s, path.start_s(), path.end_s());
  const Sensor sensor = request.height ? still_of(request).first : rig_.find(request.sensor, Pose{});
  const bool is_camera = sensor.is_camera();
  const Pose rig_from_moved{Eigen::Quaterniond::Identity(), request.rig_shift_m};
  SensorPlace place{rig_from_moved * sensor.rig_from_sensor()};
  place.only_left = request.rig_shift_m.x() == 0.0 && request.rig_shift_m.z() == 0.0;
  if (is_camera) {
    place.rig_from_sensor = place.rig_from_sensor * camera_from_turned(request);
    place.only_left = place.only_left && request.yaw_rad == 0.0 && request.pitch_rad == 0.0;
    if (request.scene_from_camera) {
      Pose world_from_camera = *request.scene_from_camera;
      world_from_camera.translation += scene_.scene().origin;
      place = {path.at(time_s).inverse() * world_from_camera, false};
    }
  }
  return Json{{"command", command_of(request, time_s, sensor, place, source_, added_)}}.dump();
}

Shot ViewSession::shot_of(const ViewRequest& request, const Sensor& sensor) const {
  const Trajectory& path = file_.world_from_rig;
  const double start_s = std::clamp(request.time_s, path.start_s(), path.end_s());
  const double end_s = std::min(start_s + sensor.duration_s(), path.end_s() + Trajectory::kExtrapolation_s);
  const Pose rig_from_moved{Eigen::Quaterniond::Identity(), request.rig_shift_m};
  Shot shot = Shot::along(path, rig_from_moved * sensor.rig_from_sensor(), start_s, end_s);
  if (request.scene_from_camera && sensor.is_camera()) {
    Pose free = *request.scene_from_camera;
    free.translation += scene_.scene().origin;
    shot.world_from_sensor_start = shot.world_from_sensor_end = free;
  }
  shot.edits = request.edits();
  return shot;
}

std::pair<Sensor, Shot> ViewSession::still_of(const ViewRequest& request) const {
  const Sensor own = rig_.find(request.sensor, Pose{});
  const double aspect = static_cast<double>(own.rows()) / static_cast<double>(own.columns());
  // Rounded as in scaled_camera(), for command_of(); a scene's camera may have any size.
  const double wanted =
      request.height ? *request.height : std::max(1.0, std::ceil(request.width * aspect - 1e-9));
  if (wanted > kMostJpeg_px || wanted * request.width > ViewRequest::kMostPixels) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("width: found {}, a picture of {} x {:.0f} px, allowed {:.0f} pixels and {} from top "
                    "to bottom",
                    request.width,
                    request.width,
                    wanted,
                    ViewRequest::kMostPixels,
                    kMostJpeg_px));
  }
  const int height = static_cast<int>(wanted);
  if (request.height) {
    Camera free;
    free.name = "free";
    free.width = request.width;
    free.height = height;
    free.fx = free.fy = 0.5 * height / std::tan(ViewRequest::kFreeHalf_rad);
    free.cx = 0.5 * request.width;
    free.cy = 0.5 * height;
    const Sensor camera(free, own.rig_from_sensor());
    return {camera, shot_of(request, camera)};
  }
  // A still picture: the camera's shutter is not simulated.
  const Sensor camera = own.resized(request.width, height)
                            .mounted(own.rig_from_sensor() * camera_from_turned(request))
                            .with_duration(0.0);
  return {camera, shot_of(request, camera)};
}

std::string ViewSession::picture(const ViewRequest& request) {
  touch();
  std::unique_lock lock(mutex_);
  const Scene& scene = scene_.scene();
  if (scene.camera.size() == 0) throw_input_error("scene", "camera set", "no particles", "at least one");
  const auto [camera, shot] = still_of(request);
  const Stopwatch render;
  const Frame frame = scene_.render(camera, shot, {.options = options_named(request.quality)});
  frame.wait();
  const double render_ms = render.ms();
  const bool is_support = request.layer == ViewLayer::kSupport;
  if (is_support && !support_) support_.emplace(scene_.device(), file_.support);
  const LayerPicture shown = is_support ? support_layer(frame, scene, copies_, *support_)
                                        : layer_of(request.layer, frame, recorded_);
  const Json boxes = json_of_outlines(camera.camera(),
                                      shot.relative_to(scene.origin),
                                      scene.actors,
                                      actors_during(scene.actors, shot, scene.origin));
  std::vector<float> points;
  if (!request.points.empty()) {
    ViewRequest of_lidar = request;
    of_lidar.sensor = request.points;
    points = seen_points(camera.camera(), shot.relative_to(scene.origin), swept(of_lidar).points);
  }
  lock.unlock();  // other requests may render meanwhile
  const Stopwatch encode;
  const ImageCode code = request.lossless ? ImageCode::kPng : ImageCode::kJpeg;
  const std::string bytes = with_points(points, encode_image(shown.image, code, kJpegQuality));
  return reply({{"render_ms", render_ms},
                {"encode_ms", encode.ms()},
                {"time_s", shot.time_start_s},
                {"boxes", boxes},
                {"scene_from_camera", json_of(shot.relative_to(scene.origin).pose_at(0.5))},
                {"points", points.size() / kSeenValues},
                {"near_m", shown.near_m},
                {"far_m", shown.far_m},
                {"unseen_share", shown.unseen_share},
                {"support", shown.support}},
               bytes.data(),
               bytes.size());
}

std::string ViewSession::probe(const ViewRequest& request) {
  touch();
  if (!request.pixel) throw_input_error("request", "pixel", "none", "a place in the picture");
  const std::lock_guard lock(mutex_);
  const Scene& scene = scene_.scene();
  if (scene.camera.size() == 0) throw_input_error("scene", "camera set", "no particles", "at least one");
  const auto [camera, shot] = still_of(request);
  const Camera& model = camera.camera();
  const auto x = static_cast<std::size_t>(std::min(request.pixel->x() * model.width, model.width - 1.0));
  const auto y = static_cast<std::size_t>(std::min(request.pixel->y() * model.height, model.height - 1.0));
  const std::size_t at = y * static_cast<std::size_t>(model.width) + x;
  FrameRequest how{.options = options_named(request.quality)};
  how.rays.assign(camera.ray_count(), false);
  how.rays[at] = true;
  how.camera_median = how.actors = true;
  const Frame frame = scene_.render(camera, shot, how);
  const RayResults& rays = frame.results();
  const Image image = frame.image();
  const std::uint32_t owner = frame.actors()[at];
  Json out = {{"colour", {image.data[3 * at], image.data[3 * at + 1], image.data[3 * at + 2]}},
              {"opacity", 1.0F - rays.transmittance[at]},
              {"distance_m", nullptr},
              {"depth_m", nullptr},
              {"point", nullptr},
              {"actor", nullptr},
              {"support", nullptr}};
  if (owner > 0) out["actor"] = scene.actors.at(owner - 1).name;
  if (rays.median[at] > 0.0F) {
    const auto distance_m = static_cast<double>(rays.median[at]);
    const Eigen::Vector3d ray = model.unproject({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
    out["distance_m"] = distance_m;
    out["depth_m"] = distance_m * ray.z();
    out["point"] = json_of(shot.relative_to(scene.origin).pose_at(0.5) * (distance_m * ray));
  }
  if (file_.support) {
    if (!support_) support_.emplace(scene_.device(), file_.support);
    out["support"] = support_->of(frame, scene, copies_)[at];
  }
  return out.dump();
}

ViewSession::Swept ViewSession::swept(const ViewRequest& request) {
  const Scene& scene = scene_.scene();
  if (scene.lidar.size() == 0) throw_input_error("scene", "LiDAR set", "no particles", "at least one");
  const FrameRequest how{.options = options_named(request.quality)};
  const Sensor lidar = rig_.find(request.sensor, Pose{});
  const Shot shot = shot_of(request, lidar);
  const Stopwatch render;
  const Frame rendered = scene_.render(lidar, shot, how);
  const LidarFrame frame = rendered.lidar();
  Swept out{shot.relative_to(scene.origin), {}, {}, frame.range.size(), render.ms()};
  out.actors = actors_during(scene.actors, shot, scene.origin);
  append_points(lidar.lidar(), frame, out.in_scene, scene.actors, out.actors, 1, out.points);
  return out;
}

std::string ViewSession::sweep(const ViewRequest& request) {
  touch();
  const std::lock_guard lock(mutex_);
  const Swept sweep = swept(request);
  return reply({{"render_ms", sweep.render_ms},
                {"rays", sweep.rays},
                {"time_s", sweep.in_scene.time_start_s},
                {"scene_from_sensor", json_of(sweep.in_scene.world_from_sensor_start)},
                {"actors", json_of_boxes(scene_.scene().actors, sweep.actors)}},
               sweep.points.data(),
               sweep.points.size() * sizeof(float));
}

}  // namespace simuli::cli
