#include "bench/render/lidar_frames.hpp"

#include <fmt/format.h>
#include <numbers>

#include "bench/particles/particle_street.hpp"
#include "bench/render/stages.hpp"

namespace simuli::bench {
Device profiled_device(const std::string& request, const Progress& note) {
  DeviceOptions options;
  options.profiling = true;
  const Device device = Device::best(request, options);
  note(fmt::format("device: {} (driver {})", device.info().label(), device.info().driver_version));
  return device;
}

Lidar even_lidar(int rows, int columns, double top, double bottom, double span) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  Lidar lidar = builtin_lidar("generic64");
  lidar.name = fmt::format("even_{}x{}", rows, columns);
  lidar.rows.clear();
  for (int row = 0; row < rows; ++row) {
    lidar.rows.push_back({(top + (bottom - top) * row / (rows - 1)) * kDegree, 0, 0, 0, 0});
  }
  lidar.columns = columns;
  lidar.azimuth_span = span;
  return lidar;
}

LidarFrames::LidarFrames(const Device& device,
                         const LidarModel& sensor,
                         const ParticleBuffers& particles,
                         const RenderOptions& options)
    : particles_(particles),
      renderer_(device, options),
      rays_(device, sensor, nominal_rays(sensor), options),
      view_{world_from_street_lidar(), world_from_street_lidar(), {0.0F, 0.0F, 0.0F}} {}

FrameTimes LidarFrames::run() {
  Profile& profile = renderer_.device().profile();
  profile.reset();
  FrameTimes times;
  times.frame_ms = time_ms([&] {
    pass_ = renderer_.render(particles_, rays_, view_);
    renderer_.device().finish();
  });
  times.stage_ms = stage_times(profile);
  return times;
}

ParticleBuffers lidar_street(const Device& device, std::int64_t particles) {
  constexpr int kShDegree = 3;
  constexpr std::uint64_t kSeed = 1;
  return {device, street_particles(SetKind::kLidar, kShDegree, particles, kSeed), Precision::kFloat};
}

}  // namespace simuli::bench
