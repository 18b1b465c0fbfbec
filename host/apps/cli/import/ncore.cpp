#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

#include "host/apps/cli/import/run_import.hpp"
#include "io/import/ncore/ncore_log.hpp"

namespace simuli::cli {
namespace {

struct NcoreCommand : NcoreOptions {
  std::vector<std::string> lidar_tables;
};

std::vector<std::string> print_ncore(const NcoreReport& r) {
  std::vector<std::string> lines = r.notes;
  const auto left_out = [&](std::size_t count, const char* what) {
    if (count > 0) lines.push_back(fmt::format("left out: {} {}", count, what));
  };
  left_out(r.unposed, "frames and boxes outside the trajectory's time");
  left_out(r.twice, "rays with the element of another ray");
  left_out(r.echoes, "further returns of a ray");
  left_out(r.points.unplaced, "points on no ray of the table");
  left_out(r.points.echoes, "second points of a ray");
  if (r.rays > 0) lines.push_back(fmt::format("{} of {} rays returned", r.returned, r.rays));
  return lines;
}

}  // namespace

void add_import_ncore(Command import, const Globals& globals) {
  const auto command = std::make_shared<NcoreCommand>();
  NcoreCommand& options = *command;
  Command sub = import.command("ncore", "a sequence of NVIDIA NCore 4: cameras, LiDARs, boxes");
  sub.option("PATH",
             options.sequence,
             ".zarr folder, .zarr.itar, a folder of several, or the .json that lists them")
      .required();
  sub.option("--cameras", command->cameras, "comma-separated cameras to import")
      .comma_separated()
      .shown_as("NAME,...", "all");
  sub.option("--lidars", command->lidars, "comma-separated LiDARs to import")
      .comma_separated()
      .shown_as("NAME,...", "all");
  sub.option(
         "--lidar",
         command->lidar_tables,
         "NAME=SENSOR, beams of a LiDAR without a beam table in the file: built-in (hesai_pandar128) or a "
         "LiDAR file "
         "(simuli fit beams)")
      .one_at_a_time();
  sub.option("--rig-frame", options.rig_frame, "the vehicle's frame").with_default();
  sub.option("--world-frame", options.world_frame, "frame of the trajectory").with_default();
  add_run<NcoreReport>(
      sub,
      "ncore",
      command,
      globals,
      [](NcoreCommand requested, const auto& progress, NcoreReport& r) {
        for (const std::string& text : requested.lidar_tables) {
          const auto [name, sensor] = parted("--lidar", text, '=', "NAME");
          requested.tables[name] = lidar_table(sensor);
        }
        return import_ncore(requested, progress, r);
      },
      print_ncore);
}

}  // namespace simuli::cli
