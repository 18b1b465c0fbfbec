// simuli tile: a LiDAR's tiles as numbers and as a picture; the fastest ones for this device.
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "host/base/error.hpp"
#include "host/cli/base/commands.hpp"
#include "host/cli/base/json_text.hpp"
#include "host/cli/report/tile_picture.hpp"
#include "host/render/rays/tile_choice.hpp"
#include "host/render/scene/tuning.hpp"
#include "io/scene/sensor_rig.hpp"

namespace simuli::cli {
namespace {

struct TileCommand {
  std::string sensor;
  std::string picture;
  TileChoice tiles;
  bool tune = false;
  std::int64_t particles = 200'000;
};

TileChoiceKey key_of(const LidarModel& sensor) {
  if (const auto* const list = std::get_if<RayList>(&sensor)) return {list->name, 0, list->ray_count()};
  const auto& lidar = std::get<Lidar>(sensor);
  return {lidar.name, lidar.rows.size(), lidar.ray_count()};
}

RayGrid grid_of(const Device& device, const LidarModel& sensor, const TileChoice& tiles) {
  RenderOptions options;
  options.lidar_tiles = tiles;
  return make_ray_grid(device, sensor, nominal_rays(sensor), options);
}

struct TileFacts {
  std::uint32_t fullest = 0, emptiest_interior = 0;  // rays of a tile
  std::uint32_t most_rows = 0, fewest_rows = 0;      // beams, or rows of a list, of a tile
  double filled = 0.0;                               // share of the slots that hold a ray
};

TileFacts facts_of(const RayGrid& grid) {
  TileFacts facts;
  const std::vector<std::uint32_t> counts = rays_of_tiles(grid);
  facts.fullest = facts.emptiest_interior = *std::max_element(counts.begin(), counts.end());
  const std::size_t columns = grid.frame.tiles_x;
  for (std::size_t tile = 0; tile < counts.size(); ++tile) {
    const std::size_t tx = tile % columns, ty = tile / columns;
    if (tx == 0 || tx + 1 == columns || ty == 0 || ty + 1 == grid.frame.tiles_y) continue;
    facts.emptiest_interior = std::min(facts.emptiest_interior, counts[tile]);
  }
  facts.fewest_rows = grid.frame.rows;
  for (std::size_t ty = 0; ty + 1 < grid.tile_rows.size(); ++ty) {
    const std::uint32_t rows = grid.tile_rows[ty + 1] - grid.tile_rows[ty];
    facts.most_rows = std::max(facts.most_rows, rows);
    facts.fewest_rows = std::min(facts.fewest_rows, rows);
  }
  facts.filled = static_cast<double>(grid.rays) / grid.frame.slots;
  return facts;
}

std::string rows_text(const TileFacts& facts, const char* to) {
  if (facts.fewest_rows == facts.most_rows) return std::to_string(facts.most_rows);
  return fmt::format("{}{}{}", facts.fewest_rows, to, facts.most_rows);
}

void print(const std::string& name, const RayGrid& grid, bool json) {
  const TileFacts facts = facts_of(grid);
  if (json) {
    const nlohmann::ordered_json out{{"sensor", name},
                                     {"rays", grid.rays},
                                     {"tile_rows", grid.frame.tiles_y},
                                     {"tile_columns", grid.frame.tiles_x},
                                     {"slots_per_tile", grid.frame.tile_rays},
                                     {"rays_of_fullest_tile", facts.fullest},
                                     {"rays_of_emptiest_interior_tile", facts.emptiest_interior},
                                     {"rows_of_highest_tile", facts.most_rows},
                                     {"rows_of_lowest_tile", facts.fewest_rows},
                                     {"share_of_slots_filled", facts.filled}};
    std::cout << json_text(out) << '\n';
    return;
  }
  std::cout << fmt::format("{}: {} rays in {} x {} tiles (elevation x azimuth)\n",
                           name,
                           grid.rays,
                           grid.frame.tiles_y,
                           grid.frame.tiles_x)
            << fmt::format("  rows per tile          {}\n", rows_text(facts, " to "))
            << fmt::format("  rays per tile          {} in the fullest, {} in the emptiest interior one\n",
                           facts.fullest,
                           facts.emptiest_interior)
            << fmt::format("  slots                  {} per tile, {:.1f} % of all hold a ray\n",
                           grid.frame.tile_rays,
                           100.0 * facts.filled);
}

void tune(const Device& device, const LidarModel& sensor, std::int64_t particles) {
  constexpr int kFrames = 15;
  const TileGrid grid = time_tiles(device, sensor, particles, kFrames);
  for (std::size_t i = 0; i < grid.times.size(); ++i) {
    const TileTime& t = grid.times[i];
    std::cerr << fmt::format(
        "{:>3} elevation tiles x {:>3} rays: {:>4} x {:>5} tiles of {:>3} slots {:>9.3f} ms{}\n",
        t.tiles.elevation,
        t.tiles.rays,
        t.tile_rows,
        t.tile_columns,
        t.tile_slots,
        t.frame_ms.median,
        i == grid.best ? "  chosen" : "");
  }
  store_tiles(device, key_of(sensor), grid.times[grid.best].tiles);
}

void tile(const TileCommand& command, const Globals& globals) {
  const LidarModel sensor = named_sensor(command.sensor).lidar();
  const Device device = Device::best(globals.device);
  if (command.tune) {
    if (command.tiles.elevation != 0 || command.tiles.rays != 0) {
      throw Error(ErrorKind::kUsage, "tile: --tune: found with tiles asked for, allowed without");
    }
    tune(device, sensor, command.particles);
  }
  const std::string& name = name_of(sensor);
  const RayGrid grid = grid_of(device, sensor, command.tiles);
  if (!command.picture.empty()) {
    const TileFacts facts = facts_of(grid);
    write_image(command.picture,
                tile_picture(grid,
                             fmt::format("{}: {} RAYS, {} ROWS AND UP TO {} RAYS IN A TILE",
                                         name,
                                         grid.rays,
                                         rows_text(facts, " TO "),
                                         facts.fullest)));
  }
  print(name, grid, globals.json);
}

}  // namespace

void add_tile(Command app, const Globals& globals) {
  const auto options = std::make_shared<TileCommand>();
  Command command = app.command("tile", "the tiles of a LiDAR: numbers, a picture, the fastest ones");
  command.option("SENSOR", options->sensor, "LiDAR file, or name of a built-in LiDAR")
      .required()
      .reads(file_unless_name)
      .completed_by(builtin_lidar_names);
  command.option("-o,--output", options->picture, "picture of beams, tiles and rays per tile (PNG)").makes();
  command
      .option("--elevation-tiles", options->tiles.elevation, "tiles from top to bottom; default: as rendered")
      .range(1, 4096);
  command.option("--rays", options->tiles.rays, "rays of a tile, at most; default: as rendered")
      .range(16, 256);
  command.flag("--tune", options->tune, "time the grid of tiles on this device and keep the fastest for it");
  command.option("--particles", options->particles, "with --tune: Gaussians of the synthetic street")
      .range(std::int64_t{1}, std::int64_t{16'000'000})
      .with_default();
  command.run([options, &globals] { tile(*options, globals); });
}

}  // namespace simuli::cli
