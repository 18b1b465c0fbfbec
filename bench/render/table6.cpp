#include "bench/render/table6.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numbers>

#include "host/render/scene/tuning.hpp"

namespace simuli::bench {
namespace {

RenderOptions options_with(const TileChoice& tiles) {
  RenderOptions options = paper_options();
  options.lidar_tiles = tiles;
  return options;
}

}  // namespace

std::vector<Row> run_table6(const std::string& device_request, std::int64_t particles, const Progress& note) {
  const Device device = profiled_device(device_request, note);
  std::vector<Row> rows;
  constexpr int kFrames = 15;
  for (const char* const name : {"generic64", "hesai_pandar128", "velodyne_vlp16"}) {
    const TileGrid grid = time_tiles(device, builtin_lidar(name), particles, kFrames);
    const std::string base = fmt::format("table6/{}_{}k", name, particles / 1000);
    double slowest = 0.0;
    for (std::size_t i = 0; i < grid.times.size(); ++i) {
      const TileTime& t = grid.times[i];
      rows.push_back(
          {fmt::format("{}/{}x{}{}", base, t.tiles.elevation, t.tiles.rays, i == grid.best ? "_chosen" : ""),
           t.frame_ms.median,
           "ms",
           t.frame_ms.half_iqr});
      slowest = std::max(slowest, t.frame_ms.median);
      note(fmt::format("{}/{}x{}: {} x {} tiles of {} slots",
                       base,
                       t.tiles.elevation,
                       t.tiles.rays,
                       t.tile_rows,
                       t.tile_columns,
                       t.tile_slots));
    }
    rows.push_back(
        {base + "/automatic", grid.automatic.frame_ms.median, "ms", grid.automatic.frame_ms.half_iqr});
    rows.push_back(
        {base + "/slowest_over_chosen", slowest / grid.times[grid.best].frame_ms.median, "x", 0.0});
  }
  return rows;
}

std::vector<Row> run_lidar_rates(const std::string& device_request, const Progress& note) {
  const Device device = profiled_device(device_request, note);
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const Lidar sensors[] = {even_lidar(64, 2650, 2.0, -24.8, kTurn),
                           even_lidar(128, 3600, 15.0, -25.0, kTurn),
                           even_lidar(16, 1800, 15.0, -15.0, kTurn)};
  std::vector<Row> rows;
  constexpr int kFrames = 11;
  for (const std::int64_t particles : {50'000, 200'000, 1'000'000}) {
    const ParticleBuffers street = lidar_street(device, particles);
    for (const Lidar& sensor : sensors) {
      RenderOptions before = options_with({(sensor.row_count() + 7) / 8, 256});
      before.culling = Culling::kOff;
      LidarFrames first(device, sensor, street, before), second(device, sensor, street, {});
      std::vector<double> a, b, ratio;
      for (int frame = -2; frame < kFrames; ++frame) {
        const double first_ms = first.run().frame_ms, second_ms = second.run().frame_ms;
        if (frame < 0) continue;
        const double mega = static_cast<double>(sensor.ray_count()) * 1e-3;
        a.push_back(mega / first_ms);
        b.push_back(mega / second_ms);
        ratio.push_back(first_ms / second_ms);
      }
      const std::string base = fmt::format("lidar_rate/{}_{}k", sensor.name.substr(5), particles / 1000);
      const Spread sa = spread_of(a), sb = spread_of(b), sr = spread_of(ratio);
      rows.push_back({base + "/before", sa.median, "MR/s", sa.half_iqr});
      rows.push_back({base + "/after", sb.median, "MR/s", sb.half_iqr});
      rows.push_back({base + "/ratio", sr.median, "x", sr.half_iqr});
    }
  }
  return rows;
}

}  // namespace simuli::bench
