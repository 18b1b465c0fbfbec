#include "bench/render/table7.hpp"

#include <array>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace simuli::bench {
namespace {

struct Case {
  const char* name;
  double span_rad;
  // requested rays; empty: all
  std::function<bool(std::size_t row, std::size_t column, std::size_t columns)> wants;
};

/// Returns the share of the last frame's pairs in tiles without a requested ray, in %.
double in_empty_tiles(const LidarFrames& frames, const SensorRays& rays, const std::vector<bool>& requested) {
  const auto& grid = rays.grid();
  const auto first = frames.pass().buffers().binned.first.download();
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

/// Counts the particles that a dense sweep between these elevations (degrees) shows without ray-based
/// culling.
std::uint32_t seen_between(const Device& device, const ParticleBuffers& street, double top, double bottom) {
  constexpr int kRows = 4096, kColumns = 64;  // no particle fits between such beams; columns do not matter
  RenderOptions options = paper_options();
  options.culling = Culling::kOff;
  LidarFrames frames(
      device, even_lidar(kRows, kColumns, top, bottom, 2.0 * std::numbers::pi), street, options);
  frames.run();
  return frames.pass().buffers().binned.visible;
}

double removed(std::uint32_t off, std::uint32_t on) { return off == 0 ? 0.0 : 100.0 * (off - on) / off; }

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kTop_deg = 2.0, kBottom_deg = -24.8;
constexpr int kFrames = 21;

std::vector<Case> all_cases() {
  return {
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
}

/// Returns the requested rays of a case.
std::vector<bool> rays_of(const Case& one, const Lidar& sensor) {
  const auto columns = static_cast<std::size_t>(sensor.columns);
  std::vector<bool> requested(sensor.ray_count(), true);
  if (!one.wants) return requested;
  for (std::size_t ray = 0; ray < requested.size(); ++ray)
    requested[ray] = one.wants(ray / columns, ray % columns, columns);
  return requested;
}

/// One case with and without culling.
class Ways {
 public:
  using Samples = std::map<std::string, std::map<std::string, std::vector<double>>>;  // by variant and stage

  Ways(const Device& device, const Lidar& sensor, const ParticleBuffers& street)
      : off(device, sensor, street, options(Culling::kOff)),
        on(device, sensor, street, options(Culling::kAuto)) {}

  void request(const std::vector<bool>& rays) {
    for (const auto& [name, way] : all()) way->request(rays);
  }
  /// Returns the times of the stages in ms, measured in turns.
  Samples time() {
    Samples samples;
    for (int frame = -2; frame < kFrames; ++frame) {
      for (const auto& [name, way] : all()) {
        FrameTimes times = way->run();
        if (frame < 0) continue;
        times.stage_ms["frame"] = times.frame_ms;
        for (const auto& [stage, ms] : times.stage_ms) samples[name][stage].push_back(ms);
      }
    }
    return samples;
  }

  LidarFrames off, on;

 private:
  std::array<std::pair<const char*, LidarFrames*>, 2> all() { return {{{"off", &off}, {"on", &on}}}; }
  static RenderOptions options(Culling culling) {
    RenderOptions o = paper_options();
    o.culling = culling;
    return o;
  }
};

void add_times(const std::string& base, const Ways::Samples& samples, std::vector<Row>& rows) {
  const auto& without = samples.at("off");
  for (const std::string stage : {"project", "sort", "bin", "blend", "frame"}) {
    const Spread plain = spread_of(without.at(stage));
    rows.push_back({base + stage + "_off", plain.median, "ms", plain.half_iqr});
    const std::vector<double>& with = samples.at("on").at(stage);
    std::vector<double> saved;
    for (std::size_t i = 0; i < with.size(); ++i)
      saved.push_back(100.0 * (1.0 - with[i] / without.at(stage)[i]));
    const Spread ms = spread_of(with), percent = spread_of(saved);
    rows.push_back({base + stage + "_on", ms.median, "ms", ms.half_iqr});
    rows.push_back({base + stage + "_saved", percent.median, "%", percent.half_iqr});
  }
}

}  // namespace

std::vector<Row> run_table7(const std::string& device_request, std::int64_t particles, const Progress& note) {
  const Device device = profiled_device(device_request, note);
  const ParticleBuffers street = lidar_street(device, particles);
  std::vector<Row> rows;
  for (const Case& one : all_cases()) {
    const Lidar sensor =
        even_lidar(64, static_cast<int>(2650 * one.span_rad / kTurn), kTop_deg, kBottom_deg, one.span_rad);
    Ways ways(device, sensor, street);
    const std::vector<bool> requested = rays_of(one, sensor);
    ways.request(requested);
    const std::string base = fmt::format("table7/{}_{}k/", one.name, particles / 1000);
    if (!ways.on.rays().can_cull())
      note(base + ": every cell of the mask holds a ray, nothing is asked");
    add_times(base, ways.time(), rows);
    const auto& a = ways.off.pass().buffers().binned;
    const auto& b = ways.on.pass().buffers().binned;
    rows.push_back({base + "particles_removed", removed(a.visible, b.visible), "%", 0.0});
    rows.push_back({base + "instances_removed", removed(a.pairs, b.pairs), "%", 0.0});
    if (!one.wants && one.span_rad == kTurn) {
      const std::uint32_t around = seen_between(device, street, 89.0, -89.0);
      const std::uint32_t within = seen_between(device, street, kTop_deg, kBottom_deg);
      rows.push_back({base + "particles_beside_the_beams", removed(around, within), "%", 0.0});
      rows.push_back({base + "particles_between_the_beams", removed(within, a.visible), "%", 0.0});
    }
    const double empty = in_empty_tiles(ways.on, ways.on.rays(), requested);
    rows.push_back({base + "instances_in_empty_tiles", empty, "%", 0.0});
  }
  return rows;
}

}  // namespace simuli::bench
