#include "bench/table7.hpp"

#include <fmt/format.h>
#include <functional>
#include <numbers>

namespace simuli::bench {
namespace {

struct Case {
  const char* name;
  double span_rad;
  std::function<bool(std::size_t row, std::size_t column, std::size_t columns)> wants;  // empty: all rays
};

/// Share of the last frame's tile instances that lie in tiles without a requested ray, in %.
double in_empty_tiles(const LidarFrames& frames, const SensorRays& rays, const std::vector<bool>& requested) {
  const auto& grid = rays.grid();
  const auto first = frames.renderer().buffers().first.download();
  std::vector<bool> used(first.size() - 1, false);
  for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
    const std::int32_t ray = grid.ray_of_slot[slot];
    if (ray >= 0 && requested[static_cast<std::size_t>(ray)]) used[slot / grid.frame.tile_rays] = true;
  }
  std::size_t empty = 0;
  for (std::size_t tile = 0; tile < used.size(); ++tile)
    empty += used[tile] ? 0 : first[tile + 1] - first[tile];
  return first.back() == 0 ? 0.0 : 100.0 * static_cast<double>(empty) / first.back();
}

double removed(std::uint32_t off, std::uint32_t on) { return off == 0 ? 0.0 : 100.0 * (off - on) / off; }

}  // namespace

std::vector<Row> run_table7(const std::string& device_request, std::int64_t particles, const Progress& note) {
  const Device device = profiled_device(device_request, note);
  const ParticleBuffers street = lidar_street(device, particles);
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const Case cases[] = {
      {"full_sweep", kTurn, {}},
      {"one_ray_in_16",
       kTurn,
       [](std::size_t row, std::size_t column, std::size_t) {
         return row % 4 == 1 && (column + row / 4) % 4 == 2;
       }},
      {"every_16th_firing",
       kTurn,
       [](std::size_t, std::size_t column, std::size_t) { return column % 16 == 0; }},
      {"every_16th_beam", kTurn, [](std::size_t row, std::size_t, std::size_t) { return row % 16 == 8; }},
      {"eighth_of_sweep",
       kTurn,
       [](std::size_t, std::size_t column, std::size_t columns) { return column < columns / 8; }},
      {"sensor_of_60_degrees", kTurn / 6.0, {}},
  };
  constexpr int kFrames = 21;
  std::vector<Row> rows;
  for (const Case& one : cases) {
    const Lidar sensor =
        even_lidar(64, static_cast<int>(2650 * one.span_rad / kTurn), 2.0, -24.8, one.span_rad);
    RenderOptions off_options, on_options;
    off_options.culling = Culling::kOff;
    on_options.culling = Culling::kAlways;
    LidarFrames off(device, sensor, street, off_options), on(device, sensor, street, on_options);
    const auto columns = static_cast<std::size_t>(sensor.columns);
    std::vector<bool> requested(sensor.ray_count(), true);
    if (one.wants) {
      for (std::size_t ray = 0; ray < requested.size(); ++ray)
        requested[ray] = one.wants(ray / columns, ray % columns, columns);
      off.rays().request(requested);
      on.rays().request(requested);
    }
    const std::string base = fmt::format("table7/{}_{}k/", one.name, particles / 1000);
    if (!on.rays().can_cull())
      note(base + ": every cell of the mask holds a ray, by default nothing is asked");
    std::map<std::string, std::vector<double>> samples;
    for (int frame = -2; frame < kFrames; ++frame) {
      for (const bool culls : {false, true}) {
        FrameTimes times = (culls ? on : off).run();
        if (frame < 0) continue;
        times.stage_ms["frame"] = times.frame_ms;
        for (const auto& [stage, ms] : times.stage_ms)
          samples[stage + (culls ? "_on" : "_off")].push_back(ms);
      }
    }
    for (const std::string stage : {"project", "sort", "bin", "blend", "frame"}) {
      const auto& without = samples.at(stage + "_off");
      const auto& with = samples.at(stage + "_on");
      std::vector<double> saved;
      for (std::size_t i = 0; i < with.size(); ++i) saved.push_back(100.0 * (1.0 - with[i] / without[i]));
      const Spread a = spread_of(without), b = spread_of(with), s = spread_of(saved);
      rows.push_back({base + stage + "_off", a.median, "ms", a.half_iqr});
      rows.push_back({base + stage + "_on", b.median, "ms", b.half_iqr});
      rows.push_back({base + stage + "_saved", s.median, "%", s.half_iqr});
    }
    const auto& a = off.renderer().buffers();
    const auto& b = on.renderer().buffers();
    rows.push_back({base + "particles_removed", removed(a.visible, b.visible), "%", 0.0});
    rows.push_back({base + "instances_removed", removed(a.instances, b.instances), "%", 0.0});
    rows.push_back({base + "instances_in_empty_tiles", in_empty_tiles(on, on.rays(), requested), "%", 0.0});
  }
  return rows;
}

}  // namespace simuli::bench
