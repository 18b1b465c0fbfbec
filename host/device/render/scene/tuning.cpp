#include "host/device/render/scene/tuning.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/core/base/stopwatch.hpp"
#include "host/core/scene/mounting.hpp"
#include "host/core/scene/particle_street.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "host/device/render/options/lane_shape.hpp"
#include "host/device/render/scene/renderer.hpp"

namespace simuli {
namespace {

/// One sensor before the street, at rest, with one way to render it.
class FrameTimer {
 public:
  FrameTimer(const ParticleBuffers& particles,
             Renderer renderer,
             SensorRays rays,
             const Pose& world_from_sensor)
      : particles_(particles),
        renderer_(std::move(renderer)),
        rays_(std::move(rays)),
        view_{world_from_sensor, world_from_sensor, {0.0F, 0.0F, 0.0F}} {}

  /// From the call to the result on the device.
  double frame_ms() {
    return time_ms([&] {
      renderer_.render(particles_, rays_, view_);
      renderer_.device().finish();
    });
  }

 private:
  const ParticleBuffers& particles_;
  Renderer renderer_;
  SensorRays rays_;
  View view_;
};

FrameTimer lidar_timer(const Device& device, const LidarModel& sensor, const ParticleBuffers& particles) {
  const RenderOptions options;
  return {particles,
          Renderer(device, options),
          SensorRays(device, sensor, nominal_rays(sensor), options),
          world_from_street_lidar()};
}

FrameTimer camera_timer(const Device& device, const ParticleBuffers& particles) {
  Camera camera;
  camera.name = "tuning";
  camera.width = 640;
  camera.height = 360;
  camera.fx = camera.fy = 380.0;
  camera.cx = 320.0;
  camera.cy = 180.0;
  const Pose level_from_camera{kForwardFromCamera, Eigen::Vector3d::Zero()};
  const RenderOptions options;
  return {particles,
          Renderer(device, options),
          SensorRays(device, camera, options),
          world_from_street_lidar() * level_from_camera};
}

/// After one frame of each that compiles.
std::vector<Spread> time_in_turns(std::vector<FrameTimer>& timers, int frames) {
  std::vector<std::vector<double>> samples(timers.size());
  for (int frame = -1; frame < frames; ++frame) {
    for (std::size_t k = 0; k < timers.size(); ++k) {
      const double ms = timers[k].frame_ms();
      if (frame >= 0) samples[k].push_back(ms);
    }
  }
  std::vector<Spread> times;
  for (std::vector<double>& own : samples) times.push_back(spread_of(std::move(own)));
  return times;
}

/// Before a street of camera particles and one of LiDAR particles.
struct Streets {
  ParticleBuffers camera, lidar;
};

/// Each tuning's frames, in turns.
std::vector<TuningTime> time_each(const Device& device,
                                  const Streets& streets,
                                  const std::vector<DeviceTuning>& tunings,
                                  int frames) {
  const LidarModel lidar = builtin_lidar("generic64");
  std::vector<FrameTimer> timers;
  for (const DeviceTuning& tuning : tunings) {
    set_tuning(device, tuning);
    timers.push_back(camera_timer(device, streets.camera));
    timers.push_back(lidar_timer(device, lidar, streets.lidar));
    // Kernels ask for their groups at their first launch.
    (void)timers[timers.size() - 2].frame_ms();
    (void)timers.back().frame_ms();
  }
  const std::vector<Spread> times = time_in_turns(timers, frames);
  std::vector<TuningTime> out;
  for (std::size_t i = 0; i < tunings.size(); ++i)
    out.push_back({tunings[i], times[2 * i], times[2 * i + 1]});
  return out;
}

/// Geometric mean of both frames, each `spreads` half distances of its quartiles from its median.
double mean_ms(const TuningTime& time, double spreads = 0.0) {
  return std::sqrt((time.camera_ms.median + spreads * time.camera_ms.half_iqr) *
                   (time.lidar_ms.median + spreads * time.lidar_ms.half_iqr));
}

/// The usual one, and other ways to spread a tile's rays.
std::vector<DeviceTuning> shapes_for(const Device& device) {
  std::vector<DeviceTuning> out{{}};
  const LaneShape usual = usual_lane_shape(device, Precision::kFloat);
  const std::vector<LaneShape> shapes =
      device.quirks().prefers_explicit_vectors
          ? std::vector<LaneShape>{{16, 16, 1}, {8, 32, 1}}
          : std::vector<LaneShape>{{1, 8, 32}, {1, 4, 64}, {1, 2, 128}, {1, 1, 256}};
  for (const LaneShape& s : shapes) {
    const bool is_usual = s.lanes == usual.lanes && s.work_items == usual.work_items;
    if (is_usual || static_cast<std::size_t>(s.work_items) > device.info().max_work_group_size) continue;
    out.push_back({.lanes = s.lanes, .vectors = s.vectors, .work_items = s.work_items});
  }
  return out;
}

std::vector<DeviceTuning> groups_for(const DeviceInfo& device, const DeviceTuning& shape) {
  std::vector<DeviceTuning> out{{}};
  if (shape != DeviceTuning{}) out.push_back(shape);
  for (const int group : {16, 32, 64, 128, 256}) {
    if (static_cast<std::size_t>(group) > device.max_work_group_size) continue;
    out.push_back(shape);
    out.back().group = group;
  }
  return out;
}

/// The fastest of those that are clearly faster than the first.
std::size_t best_of(const std::vector<TuningTime>& times) {
  constexpr double kWorthIt = 0.98;
  const double usual = std::min(kWorthIt * mean_ms(times[0]), mean_ms(times[0], -1.0));
  std::size_t best = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (mean_ms(times[i], 1.0) < usual && (best == 0 || mean_ms(times[i]) < mean_ms(times[best]))) best = i;
  }
  return best;
}

}  // namespace

TuningSearch time_tunings(const Device& device, std::int64_t particles, int frames) {
  constexpr int kShDegree = 3;
  constexpr std::uint64_t kSeed = 1;
  const auto street = [&](SetKind kind) {
    return ParticleBuffers(device, street_particles(kind, kShDegree, particles, kSeed), Precision::kFloat);
  };
  const Streets streets{street(SetKind::kCamera), street(SetKind::kLidar)};
  struct Restored {
    const Device& device;
    DeviceTuning before = tuning_of(device);
    ~Restored() { set_tuning(device, before); }
  } const restored{device};
  TuningSearch search{time_each(device, streets, shapes_for(device), frames)};
  const DeviceTuning shape = search.times[best_of(search.times)].tuning;
  // The last round has the usual way in it again: ratios are those of one round.
  std::vector<TuningTime> last = time_each(device, streets, groups_for(device.info(), shape), frames);
  const std::size_t first = search.times.size();
  const std::size_t best = best_of(last);
  search.times.insert(search.times.end(), last.begin(), last.end());
  search.best = best == 0 ? 0 : first + best;
  return search;
}

}  // namespace simuli
