#include "bench/trade/trade_views.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>
#include <optional>
#include <utility>

#include "bench/render/scene.hpp"
#include "host/base/error.hpp"
#include "host/sensors/lidar_library.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/base/frames.hpp"
#include "host/scene/particle_street.hpp"

namespace simuli::bench {
namespace {

constexpr std::int64_t kParticles = 200'000;
constexpr double kSpin_s = 0.1;  // one turn of most automotive LiDARs

/// 15 m/s along the street and 20 degrees/s, for so long.
View driven(const Pose& start, double seconds) {
  Pose end = start;
  end.translation += 15.0 * seconds * Eigen::Vector3d::UnitX();
  const double turned_rad = 20.0 * seconds * std::numbers::pi / 180.0;
  end.rotation = Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitZ()) * start.rotation;
  return {start, end};
}

/// Up to `count` of them, spread evenly.
template <class T>
std::vector<T> spread_over(const std::vector<T>& all, int count) {
  const std::size_t wanted = std::min(all.size(), static_cast<std::size_t>(count));
  std::vector<T> some;
  for (std::size_t i = 0; i < wanted; ++i) some.push_back(all[(2 * i + 1) * all.size() / (2 * wanted)]);
  return some;
}

struct Span {
  double start_s = 0.0, end_s = 0.0;
  std::string file;  // of a recorded sweep
};

/// Frames of a sensor in the log; without a log, at the poses of the scene's path.
std::vector<Span> spans_of(const TradeSensor& sensor, const SceneFile& scene, const std::optional<Log>& log) {
  std::vector<Span> spans;
  if (!log) {
    const bool global = sensor.is_camera;  // how long a picture takes is in the log alone
    for (const TimedPose& p : scene.world_from_rig.poses()) {
      const double end_s = p.time_s + (global ? 0.0 : kSpin_s);
      if (end_s <= scene.world_from_rig.end_s()) spans.push_back({p.time_s, end_s, {}});
    }
    return spans;
  }
  if (sensor.is_camera) {
    for (const ImageFrame& f : log->images) {
      if (f.camera == sensor.name) spans.push_back({f.time_start_s, f.time_end_s, {}});
    }
    return spans;
  }
  for (const SweepFrame& f : log->sweeps) {
    if (f.lidar == sensor.name) spans.push_back({f.time_start_s, f.time_end_s, f.file});
  }
  return spans;
}

}  // namespace

SensorRays TradeSensor::on(const Device& device, const TradeView& view, const RenderOptions& options) const {
  return is_camera ? SensorRays(device, camera, options) : SensorRays(device, lidar, view.rays, options);
}

TradeScene moving_street() {
  constexpr double kReadOut_s = 0.02;
  constexpr int kShDegree = 3;
  TradeScene out;
  out.scene.camera = street_particles(SetKind::kCamera, kShDegree, kParticles, 1);
  out.scene.lidar = street_particles(SetKind::kLidar, kShDegree, kParticles, 1);
  TradeSensor camera;
  camera.name = "camera";
  camera.is_camera = true;
  camera.camera = bench_camera();
  camera.camera.shutter = ShutterKind::kTopToBottom;
  camera.views.push_back({driven(world_from_bench_camera(), kReadOut_s), {}, 0.0});
  TradeSensor lidar;
  lidar.name = "lidar";
  lidar.lidar = builtin_lidar("generic64");
  lidar.views.push_back({driven(world_from_street_lidar(), kSpin_s), nominal_rays(lidar.lidar, kSpin_s), 0.0});
  out.sensors = {std::move(camera), std::move(lidar)};
  return out;
}

TradeScene trade_scene(const TradeOptions& options) {
  namespace fs = std::filesystem;
  if (options.folders.empty()) {
    TradeScene street = moving_street();
    std::erase_if(street.sensors,
                  [&](const TradeSensor& s) { return !options.sensor.empty() && s.name != options.sensor; });
    if (street.sensors.empty()) {
      throw Error(ErrorKind::kUsage,
                  fmt::format("--sensor: found \"{}\", allowed camera, lidar", options.sensor));
    }
    return street;
  }
  SceneFile file = read_scene(options.folders.front());
  std::optional<Log> log;
  if (options.folders.size() > 1) log = read_log(options.folders[1]);
  TradeScene out;
  for (const LogCamera& c : file.cameras) {
    TradeSensor sensor;
    sensor.name = c.model.name;
    sensor.is_camera = true;
    sensor.camera = scaled_camera(c.model, options.image_scale);
    out.sensors.push_back(std::move(sensor));
  }
  for (const LogLidar& l : file.lidars) {
    TradeSensor sensor;
    sensor.name = name_of(l.model);
    sensor.lidar = l.model;
    out.sensors.push_back(std::move(sensor));
  }
  std::vector<std::string> known;
  for (const TradeSensor& s : out.sensors) known.push_back(s.name);
  if (!options.sensor.empty() && std::find(known.begin(), known.end(), options.sensor) == known.end()) {
    throw Error(ErrorKind::kUsage,
                fmt::format("--sensor: found \"{}\", allowed {}", options.sensor, fmt::join(known, ", ")));
  }
  std::erase_if(out.sensors,
                [&](const TradeSensor& s) { return !options.sensor.empty() && s.name != options.sensor; });
  for (TradeSensor& sensor : out.sensors) {
    const std::vector<Span> spans = spread_over(spans_of(sensor, file, log), options.views);
    if (spans.empty()) {
      throw_input_error(options.folders.back(), "frames of " + sensor.name, "none", "at least one");
    }
    Pose rig_from_sensor;
    for (const LogCamera& c : file.cameras) {
      if (c.model.name == sensor.name) rig_from_sensor = c.rig_from_camera;
    }
    for (const LogLidar& l : file.lidars) {
      if (name_of(l.model) == sensor.name) rig_from_sensor = l.rig_from_lidar;
    }
    for (const Span& span : spans) {
      TradeView view;
      view.time_s = 0.5 * (span.start_s + span.end_s);
      view.view = view_at(log ? log->world_from_rig : file.world_from_rig,
                          rig_from_sensor,
                          span.start_s,
                          span.end_s,
                          file.scene,
                          sensor.is_camera ? SetKind::kCamera : SetKind::kLidar);
      if (!sensor.is_camera) {
        view.rays = span.file.empty() ? nominal_rays(sensor.lidar, span.end_s - span.start_s)
                                      : read_sweep(log->folder / span.file, sensor.lidar).rays;
      }
      sensor.views.push_back(std::move(view));
    }
  }
  out.scene = std::move(file.scene);
  return out;
}

}  // namespace simuli::bench
