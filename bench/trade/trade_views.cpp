#include "bench/trade/trade_views.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numbers>
#include <optional>
#include <utility>

#include "bench/particles/particle_street.hpp"
#include "bench/render/scene.hpp"
#include "host/core/base/error.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "io/log/log.hpp"
#include "io/scene/sensor_rig.hpp"
#include "optim/base/frames.hpp"

namespace simuli::bench {
namespace {

constexpr std::int64_t kParticles = 200'000;

/// Returns a motion of 15 m/s along the street and 20 degrees/s for `seconds`.
Shot driven(const Pose& start, double seconds) {
  Pose end = start;
  end.translation += 15.0 * seconds * Eigen::Vector3d::UnitX();
  const double turned_rad = 20.0 * seconds * std::numbers::pi / 180.0;
  end.rotation = Eigen::AngleAxisd(turned_rad, Eigen::Vector3d::UnitZ()) * start.rotation;
  return {start, end, 0.0, 0.0};
}

/// Returns up to `count` evenly spread elements.
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

/// Returns the frames of a sensor in the log; without a log, frames at the ego poses of the scene.
std::vector<Span> spans_of(const Sensor& sensor, const SceneFile& scene, const std::optional<Log>& log) {
  std::vector<Span> spans;
  if (!log) {
    for (const TimedPose& p : scene.world_from_rig.poses()) {
      const double end_s = p.time_s + sensor.duration_s();
      if (end_s <= scene.world_from_rig.end_s()) spans.push_back({p.time_s, end_s, {}});
    }
    return spans;
  }
  if (sensor.is_camera()) {
    for (const ImageFrame& f : log->images) {
      if (f.camera == sensor.name()) spans.push_back({f.time_start_s, f.time_end_s, {}});
    }
    return spans;
  }
  for (const SweepFrame& f : log->sweeps) {
    if (f.lidar == sensor.name()) spans.push_back({f.time_start_s, f.time_end_s, f.file});
  }
  return spans;
}

}  // namespace

TradeScene moving_street() {
  constexpr double kReadOut_s = 0.02;
  constexpr int kShDegree = 3;
  TradeScene out;
  out.scene.camera = street_particles(SetKind::kCamera, kShDegree, kParticles, 1);
  out.scene.lidar = street_particles(SetKind::kLidar, kShDegree, kParticles, 1);
  out.scene.lidar_background = {0.0F, 0.0F, 0.0F};
  Camera rolling = bench_camera();
  rolling.shutter = ShutterKind::kTopToBottom;
  const Sensor spinning(builtin_lidar("generic64"));
  TradeSensor camera{"camera", true, {{Sensor(rolling), driven(world_from_bench_camera(), kReadOut_s)}}};
  TradeSensor lidar{"lidar", false, {{spinning, driven(world_from_street_lidar(), spinning.duration_s())}}};
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
  const SensorRig rig(file);
  for (const Sensor& sensor : rig.sensors()) {
    out.sensors.push_back({sensor.name(), sensor.is_camera(), {}});
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
    Sensor mounted = rig.find(sensor.name);
    const std::vector<Span> spans = spread_over(spans_of(mounted, file, log), options.views);
    if (spans.empty()) {
      throw_input_error(options.folders.back(), "frames of " + sensor.name, "none", "at least one");
    }
    if (sensor.is_camera) {
      const Camera scaled = scaled_camera(mounted.camera(), options.image_scale);
      mounted = mounted.resized(scaled.width, scaled.height);
    }
    const Trajectory& path = log ? log->world_from_rig : file.world_from_rig;
    for (const Span& span : spans) {
      const bool is_recorded = !span.file.empty();
      sensor.views.push_back(
          {is_recorded ? mounted.with_rays(read_sweep(log->folder / span.file, mounted.lidar()).rays)
                       : mounted,
           Shot::along(path, mounted.rig_from_sensor(), span.start_s, span.end_s)});
    }
  }
  out.scene = std::move(file.scene);
  return out;
}

}  // namespace simuli::bench
