#include "host/cli/view/view_session.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/render/options/quality.hpp"
#include "host/sensors/lidar_library.hpp"
#include "io/base/json_reader.hpp"
#include "io/picture/image.hpp"

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

RenderOptions options_named(const std::string& quality) {
  const std::optional<Quality> known = find_quality(quality);
  if (known) return options_of(*known);
  throw Error(ErrorKind::kUsage,
              fmt::format("quality: found \"{}\", allowed {}", quality, fmt::join(quality_names(), ", ")));
}

}  // namespace

ViewRequest parse_view_request(const std::string& json) {
  constexpr double kFarthest_m = 1e6;
  return read_json_text(json, "request", [](JsonObject& o) {
    ViewRequest r;
    r.sensor = o.text("sensor");
    r.quality = o.text("quality");
    r.time_s = o.number("time_s");
    r.width = static_cast<int>(o.integer("width", ViewRequest::kNarrowest_px, ViewRequest::kWidest_px));
    r.rig_shift_m = {o.number("forward_m", -kFarthest_m, kFarthest_m),
                     o.number("left_m", -kFarthest_m, kFarthest_m),
                     o.number("up_m", -kFarthest_m, kFarthest_m)};
    r.yaw_rad = o.number("yaw_rad", -1e3, 1e3);
    r.pitch_rad = o.number("pitch_rad", -1e3, 1e3);
    if (o.has("scene_from_camera")) {
      r.scene_from_camera = o.object("scene_from_camera", [](JsonObject& p) {
        const Eigen::Vector4d q = p.vector<4>("q");
        if (!(q.norm() > 1e-6)) throw_input_error("request", p.field("q"), "zero", "a quaternion");
        return Pose{Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), p.vector<3>("t")};
      });
    }
    const Json& removed = o.get("removed");
    const auto is_name = [](const Json& name) { return name.is_string(); };
    if (!removed.is_array() || !std::all_of(removed.begin(), removed.end(), is_name)) {
      throw_input_error("request", "removed", removed.type_name(), "an array of actors' names");
    }
    for (const Json& name : removed) r.removed.push_back(name.get<std::string>());
    o.object("moved", [&](JsonObject& moved) {
      for (const auto& item : o.get("moved").items()) r.moved[item.key()] = moved.vector<3>(item.key());
    });
    return r;
  });
}

ViewSession::ViewSession(const Globals& globals, SceneFile file)
    : globals_(globals),
      file_(std::move(file)),
      rig_(file_),
      scene_(Device::best(globals.device), std::move(file_.scene)),
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
                    {"training", progress_.training},
                    {"iteration", s.iteration},
                    {"iterations", progress_.iterations},
                    {"psnr_db", s.psnr_db},  // not finite: null
                    {"distance_m", s.distance_m},
                    {"camera_particles", s.camera_particles},
                    {"lidar_particles", s.lidar_particles}};
  return out.dump();
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
  for (const auto& [name, by_m] : request.moved) shot.edits.push_back({name, ActorEdit::Move{by_m}});
  for (const std::string& name : request.removed) shot.edits.push_back({name, ActorEdit::Remove{}});
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
  const double wanted = std::max(1.0, std::round(request.width * aspect));  // of a scene's camera: any
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
  const Image image = scene_.render(camera, shot, how).image();
  const double render_ms = render.ms();
  lock.unlock();  // others may render meanwhile
  const Stopwatch encode;
  const std::string jpeg = encode_image(image, ImageCode::kJpeg, kJpegQuality);
  return reply({{"render_ms", render_ms}, {"encode_ms", encode.ms()}}, jpeg.data(), jpeg.size());
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
  std::vector<float> points;  // x, y, z, intensity
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (!frame.is_return(i)) continue;
    for (const double value : ends[i]) points.push_back(static_cast<float>(value));
    points.push_back(frame.intensity[i]);
  }
  const std::vector<ActorView> views = actors_during(scene.actors, shot, scene.origin);
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
