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
#include <numbers>
#include <utility>

#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/apps/cli/view/view_layers.hpp"
#include "host/core/base/activity.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "host/core/base/stopwatch.hpp"
#include "host/core/scene/placement.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "host/device/render/options/quality.hpp"
#include "io/base/json_reader.hpp"
#include "io/picture/image.hpp"
#include "io/scene/splat_scene.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli::cli {
namespace {

constexpr int kJpegQuality = 90;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Json json_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Json json_of(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  return {{"t", json_of(pose.translation)}, {"q", {q.w(), q.x(), q.y(), q.z()}}};
}

std::string reply(const Json& info, const void* payload, std::size_t bytes) {
  const std::string text = info.dump();
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string out;
  for (unsigned shift = 0; shift < 32; shift += 8) out += static_cast<char>(length >> shift & 0xFFU);
  out += text;
  out.resize((out.size() + 3) / 4 * 4, '\0');
  out.append(static_cast<const char*>(payload), bytes);
  return out;
}

/// One more than the number of the first actor whose box holds the point at that share of the frame; 0: none.
std::size_t actor_at(const Eigen::Vector3d& point,
                     const std::vector<Actor>& actors,
                     const std::vector<ActorView>& views,
                     float share) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].is_there) continue;
    const Pose scene_from_actor =
        interpolate(views[i].scene_from_actor_start, views[i].scene_from_actor_end, share);
    const Eigen::Vector3d inside = scene_from_actor.inverse() * point;
    if ((inside.cwiseAbs().array() <= 0.5 * actors[i].size_m.array()).all()) return i + 1;
  }
  return 0;
}

RenderOptions options_named(const std::string& quality) {
  const std::optional<Quality> known = find_quality(quality);
  if (known) return options_of(*known);
  refuse("quality", quality, fmt::format("{}", fmt::join(quality_names(), ", ")));
}

/// `wanted`, or with a number behind it where the scene has one of that name.
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
      asked_s_(-std::numeric_limits<double>::infinity()) {
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
  return now_s() - asked_s_;
}

void ViewSession::touch() {
  const std::lock_guard lock(progress_mutex_);
  asked_s_ = now_s();
}

std::string ViewSession::describe() const {
  const std::lock_guard lock(mutex_);
  const Scene& scene = scene_.scene();
  std::vector<std::string> cameras, lidars;
  for (const LogCamera& c : file_.cameras) cameras.push_back(c.model.name);
  for (const LogLidar& l : file_.lidars) lidars.push_back(name_of(l.model));
  Json actors = Json::array();
  for (const Actor& a : scene.actors) {
    actors.push_back({{"name", a.name}, {"kind", a.kind}, {"size_m", json_of(a.size_m)}});
  }
  Json path = Json::array();
  const std::vector<TimedPose>& poses = file_.world_from_rig.poses();
  for (const TimedPose& p : poses) path.push_back(json_of(p.pose.translation - scene.origin));
  const Eigen::Vector3d ahead = poses.front().pose.rotation * Eigen::Vector3d::UnitX();
  const Json out = {{"name", scene.name},
                    {"device", scene_.device().info().label()},
                    {"cameras", cameras},
                    {"builtin_cameras", builtin_camera_names()},
                    {"lidars", lidars},
                    {"builtin_lidars", builtin_lidar_names()},
                    {"qualities", quality_names()},
                    {"quality", quality_names().at(static_cast<std::size_t>(globals_.quality))},
                    {"time_start_s", file_.world_from_rig.start_s()},
                    {"time_end_s", file_.world_from_rig.end_s()},
                    {"heading_rad", std::atan2(ahead.y(), ahead.x())},
                    {"path", path},
                    {"actors", actors}};
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
                    {"psnr_db", s.psnr_db},  // not finite: null
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
  scene_.set_scene(std::move(scene));
  added_.push_back(option);
  const std::lock_guard progress_lock(progress_mutex_);
  ++version_;
}

std::string ViewSession::duplicate(const std::string& json) {
  const std::string name = read_json_text(json, "request", [](JsonObject& o) { return o.text("actor"); });
  std::string copy;
  change([&](Scene& scene) {
    copy = new_name(scene, name);
    const auto of_copy = copies_.find(name);
    copies_[copy] = of_copy == copies_.end() ? name : of_copy->second;
    duplicate_actor(scene, name, copy);
    return fmt::format("--duplicate {}:{}", name, copy);
  });
  return Json{{"actor", copy}}.dump();
}

std::string ViewSession::add(const std::string& file_name, const std::string& bytes, double time_s) {
  const std::filesystem::path file = name_from(file_name);
  if (!is_splat_file(file)) throw_input_error(file.string(), "extension", "another one", kSplatExtensions);
  const Scene object = scene_of_splats(read_splats(bytes, file), file).scene;
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
  return Json{{"actor", name}, {"moved_m", json_of(moved_m)}}.dump();
}

std::string ViewSession::command(const ViewRequest& request) const {
  if (source_.scene.empty()) {
    throw_usage_error("command", "a scene that is being trained", "one on disk");
  }
  const std::lock_guard lock(mutex_);
  const Trajectory& path = file_.world_from_rig;
  const double time_s = std::clamp(request.time_s, path.start_s(), path.end_s());
  const Sensor sensor = rig_.find(request.sensor, Pose{});
  return Json{{"command", command_of(request, time_s, sensor, source_, added_)}}.dump();
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

std::string ViewSession::picture(const ViewRequest& request) {
  touch();
  std::unique_lock lock(mutex_);
  if (scene_.scene().camera.size() == 0)
    throw_input_error("scene", "camera set", "no particles", "at least one");
  const FrameRequest how{.options = options_named(request.quality)};
  const Sensor own = rig_.find(request.sensor, Pose{});
  const double aspect = static_cast<double>(own.rows()) / static_cast<double>(own.columns());
  // As scaled_camera() has it, for command_of(); of a scene's camera any number.
  const double wanted = std::max(1.0, std::ceil(request.width * aspect - 1e-9));
  if (wanted > ViewRequest::kTallest_px || wanted * request.width > ViewRequest::kMostPixels) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("width: found {}, a picture of {} x {:.0f} px, allowed {:.0f} pixels and {:.0f} from top "
                    "to bottom",
                    request.width,
                    request.width,
                    wanted,
                    ViewRequest::kMostPixels,
                    ViewRequest::kTallest_px));
  }
  const int height = static_cast<int>(wanted);
  // To the left is about the camera's -y, which is up; down about its x.
  const Pose camera_from_turned{
      Eigen::Quaterniond(Eigen::AngleAxisd(-request.yaw_rad, Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(-request.pitch_rad, Eigen::Vector3d::UnitX())),
      Eigen::Vector3d::Zero()};
  // A still: the shutter is not followed.
  const Sensor camera = own.resized(request.width, height)
                            .mounted(own.rig_from_sensor() * camera_from_turned)
                            .with_duration(0.0);
  const Shot shot = shot_of(request, camera);
  const Stopwatch render;
  const Frame frame = scene_.render(camera, shot, how);
  frame.wait();
  const double render_ms = render.ms();
  const bool is_support = request.layer == ViewLayer::kSupport;
  if (is_support && !support_) support_.emplace(scene_.device(), file_.support);
  const LayerPicture shown = is_support ? support_layer(frame, scene_.scene(), copies_, *support_)
                                        : layer_of(request.layer, frame, recorded_);
  lock.unlock();  // others may render meanwhile
  const Stopwatch encode;
  const ImageCode code = request.lossless ? ImageCode::kPng : ImageCode::kJpeg;
  const std::string bytes = encode_image(shown.image, code, kJpegQuality);
  return reply({{"render_ms", render_ms},
                {"encode_ms", encode.ms()},
                {"near_m", shown.near_m},
                {"far_m", shown.far_m},
                {"unseen_share", shown.unseen_share},
                {"support", shown.support}},
               bytes.data(),
               bytes.size());
}

std::string ViewSession::sweep(const ViewRequest& request) {
  touch();
  const std::lock_guard lock(mutex_);
  const Scene& scene = scene_.scene();
  if (scene.lidar.size() == 0) throw_input_error("scene", "LiDAR set", "no particles", "at least one");
  const FrameRequest how{.options = options_named(request.quality)};
  const Sensor lidar = rig_.find(request.sensor, Pose{});
  const Shot shot = shot_of(request, lidar);
  const Stopwatch render;
  const Frame rendered = scene_.render(lidar, shot, how);
  const LidarFrame frame = rendered.lidar();
  const double render_ms = render.ms();
  const Shot in_scene = shot.relative_to(scene.origin);
  const std::vector<Eigen::Vector3d> ends = points_of(lidar.lidar(), frame, in_scene, PointFrame::kWorld);
  const std::vector<ActorView> views = actors_during(scene.actors, shot, scene.origin);
  const bool has_rows = std::holds_alternative<Lidar>(lidar.lidar());
  std::vector<float> points;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (!frame.is_return(i)) continue;
    for (const double value : ends[i]) points.push_back(static_cast<float>(value));
    const float share = frame.rays.time_fraction[i];
    points.push_back(frame.intensity[i]);
    points.push_back(has_rows ? static_cast<float>(i / lidar.columns()) : 0.0F);
    points.push_back(share);
    points.push_back(static_cast<float>(actor_at(ends[i], scene.actors, views, share)));
  }
  Json actors = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Actor& actor = scene.actors[i];
    Json entry = json_of(views[i].scene_from_actor_start);
    entry["name"] = actor.name;
    entry["size"] = json_of(actor.size_m);
    entry["is_there"] = views[i].is_there;
    actors.push_back(std::move(entry));
  }
  return reply({{"render_ms", render_ms},
                {"rays", frame.range.size()},
                {"scene_from_sensor", json_of(in_scene.world_from_sensor_start)},
                {"actors", actors}},
               points.data(),
               points.size() * sizeof(float));
}

}  // namespace simuli::cli
