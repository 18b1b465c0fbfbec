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
#include "host/cli/base/pictures.hpp"
#include "host/render/options/quality.hpp"
#include "host/render/scene/seen.hpp"
#include "host/sensors/lidar_library.hpp"
#include "io/base/json_reader.hpp"
#include "io/picture/image.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

constexpr double kSweep_s = 0.1;  // one turn at the 10 Hz of most automotive LiDARs
constexpr int kJpegQuality = 90;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Milliseconds since the object was made.
class Stopwatch {
 public:
  [[nodiscard]] double ms() const { return 1e3 * (now_s() - start_s_); }

 private:
  double start_s_ = now_s();
};

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
    for (const Json& name : o.get("removed")) r.removed.push_back(name.get<std::string>());
    o.object("moved", [&](JsonObject& moved) {
      for (const auto& item : o.get("moved").items()) r.moved[item.key()] = moved.vector<3>(item.key());
    });
    return r;
  });
}

struct ViewSession::Stage {
  Stage(const Device& device, const Scene& scene, Quality wanted)
      : quality(wanted),
        options(options_of(wanted)),
        camera_renderer(device, options),
        lidar_renderer(device, options),
        camera_set(device, scene.camera, options),
        lidar_set(device, scene.lidar, options),
        look(device, scene, options.precision) {}

  Quality quality;
  RenderOptions options;
  Renderer camera_renderer, lidar_renderer;
  ParticleBuffers camera_set, lidar_set;
  SceneLook look;
  // Of the sensors shown last.
  Camera camera;
  std::unique_ptr<SensorRays> camera_rays;
  LidarModel lidar;
  LidarRays beams;
  std::unique_ptr<SensorRays> lidar_rays;
};

ViewSession::ViewSession(const Globals& globals, SceneFile file)
    : globals_(globals),
      file_(std::move(file)),
      device_(Device::best(globals.device)),
      asked_s_(-std::numeric_limits<double>::infinity()) {}

ViewSession::~ViewSession() = default;

void ViewSession::show(Scene scene) {
  {
    const std::lock_guard lock(mutex_);
    stage_.reset();
    file_.scene = std::move(scene);
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
  const Scene& scene = file_.scene;
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
                    {"device", device_.info().label()},
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

ViewSession::Stage& ViewSession::stage(const std::string& quality) {
  const std::optional<Quality> known = find_quality(quality);
  if (!known) {
    throw Error(ErrorKind::kUsage,
                fmt::format("quality: found \"{}\", allowed {}", quality, fmt::join(quality_names(), ", ")));
  }
  if (!stage_ || stage_->quality != *known) {
    stage_.reset();  // first, so that two scenes are never on the device at once
    stage_ = std::make_unique<Stage>(device_, file_.scene, *known);
  }
  return *stage_;
}

View ViewSession::view_of_request(const ViewRequest& request,
                                  const Pose& rig_from_sensor,
                                  double duration_s,
                                  SetKind kind) const {
  const Trajectory& path = file_.world_from_rig;
  const double start_s = std::clamp(request.time_s, path.start_s(), path.end_s());
  const double end_s = std::min(start_s + duration_s, path.end_s() + Trajectory::kExtrapolation_s);
  const Pose rig_from_moved{Eigen::Quaterniond::Identity(), request.rig_shift_m};
  View view = view_at(path, rig_from_moved * rig_from_sensor, start_s, end_s, file_.scene, kind);
  if (request.scene_from_camera && kind == SetKind::kCamera) {
    view.scene_from_sensor_start = view.scene_from_sensor_end = *request.scene_from_camera;
  }
  const std::vector<Actor>& actors = file_.scene.actors;
  for (const std::string& name : request.removed) view.actors[find_actor(actors, name)].is_there = false;
  for (const auto& [name, by_m] : request.moved) {
    ActorView& actor = view.actors[find_actor(actors, name)];
    const Pose actor_from_moved{Eigen::Quaterniond::Identity(), by_m};
    actor.scene_from_actor_start = actor.scene_from_actor_start * actor_from_moved;
    actor.scene_from_actor_end = actor.scene_from_actor_end * actor_from_moved;
  }
  return view;
}

std::string ViewSession::picture(const ViewRequest& request) {
  touch();
  std::unique_lock lock(mutex_);
  if (file_.scene.camera.size() == 0)
    throw_input_error("scene", "camera set", "no particles", "at least one");
  LogCamera camera;
  if (const LogCamera* const own = file_.find_camera(request.sensor)) {
    camera = *own;
  } else {
    camera.model = builtin_camera(request.sensor);
    if (!file_.cameras.empty()) camera.rig_from_camera = file_.cameras.front().rig_from_camera;
  }
  const double aspect = static_cast<double>(camera.model.height) / camera.model.width;
  const int height = std::max(1, static_cast<int>(std::lround(request.width * aspect)));
  const Camera model = camera.model.resized(request.width, height);
  Stage& s = stage(request.quality);
  if (!s.camera_rays || s.camera.name != model.name || s.camera.width != model.width) {
    s.camera_rays = std::make_unique<SensorRays>(device_, model, s.options);
    s.camera = model;
  }
  // To the left is about the camera's -y, which is up; down about its x.
  const Pose camera_from_turned{
      Eigen::Quaterniond(Eigen::AngleAxisd(-request.yaw_rad, Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(-request.pitch_rad, Eigen::Vector3d::UnitX())),
      Eigen::Vector3d::Zero()};
  // A still: the shutter is not followed.
  const View view =
      view_of_request(request, camera.rig_from_camera * camera_from_turned, 0.0, SetKind::kCamera);
  const Stopwatch render;
  const Pass pass =
      s.look.render(s.camera_renderer, s.camera_set, *s.camera_rays, view, request.sensor, request.time_s);
  const Image image = picture_of(pass.results(), model);
  const double render_ms = render.ms();
  lock.unlock();  // others may render meanwhile
  const Stopwatch encode;
  const std::string jpeg = encode_image(image, ImageCode::kJpeg, kJpegQuality);
  return reply({{"render_ms", render_ms}, {"encode_ms", encode.ms()}}, jpeg.data(), jpeg.size());
}

std::string ViewSession::sweep(const ViewRequest& request) {
  touch();
  const std::lock_guard lock(mutex_);
  if (file_.scene.lidar.size() == 0) throw_input_error("scene", "LiDAR set", "no particles", "at least one");
  LogLidar lidar;
  if (const LogLidar* const own = file_.find_lidar(request.sensor)) {
    lidar = *own;
  } else {
    lidar.model = builtin_lidar(request.sensor);
    if (!file_.lidars.empty()) lidar.rig_from_lidar = file_.lidars.front().rig_from_lidar;
  }
  Stage& s = stage(request.quality);
  if (!s.lidar_rays || name_of(s.lidar) != request.sensor) {
    s.lidar = lidar.model;
    s.beams = nominal_rays(s.lidar, kSweep_s);
    s.lidar_rays = std::make_unique<SensorRays>(device_, s.lidar, s.beams, s.options);
  }
  const View view = view_of_request(request, lidar.rig_from_lidar, kSweep_s, SetKind::kLidar);
  const Stopwatch render;
  const Pass pass = s.lidar_renderer.render(s.lidar_set, *s.lidar_rays, view);
  const LidarFrame frame = lidar_frame(s.lidar, s.beams, pass.results());
  const double render_ms = render.ms();
  // Poses of a view, and so the points, are in the scene's frame.
  const PointCloud cloud =
      point_cloud(s.lidar, frame, {view.scene_from_sensor_start, view.scene_from_sensor_end, 0.0, 0.0});
  const Eigen::Matrix<float, Eigen::Dynamic, 4, Eigen::RowMajor> points = cloud.values.leftCols<4>();
  Json actors = Json::array();
  for (std::size_t i = 0; i < view.actors.size(); ++i) {
    const Actor& actor = file_.scene.actors[i];
    Json entry = json_of(view.actors[i].scene_from_actor_start);
    entry["name"] = actor.name;
    entry["size"] = json_of(actor.size_m);
    entry["is_there"] = view.actors[i].is_there;
    actors.push_back(std::move(entry));
  }
  return reply({{"render_ms", render_ms},
                {"rays", frame.range.size()},
                {"scene_from_sensor", json_of(view.scene_from_sensor_start)},
                {"actors", actors}},
               points.data(),
               static_cast<std::size_t>(points.size()) * sizeof(float));
}

}  // namespace simuli::cli
