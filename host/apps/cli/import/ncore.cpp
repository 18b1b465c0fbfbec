#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "host/apps/cli/import/run_import.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/base/split.hpp"
#include "io/import/ncore/ncore_log.hpp"

namespace simuli::cli {
namespace {

struct NcoreCommand {
  NcoreOptions options;
  std::vector<std::string> tables;
};

void tell_ncore(const NcoreReport& r) {
  for (const std::string& note : r.notes) std::cerr << on_one_line(note) << '\n';
  const auto left_out = [](std::size_t count, const char* what) {
    if (count > 0) std::cerr << fmt::format("left out: {} {}\n", count, what);
  };
  left_out(r.unposed, "frames and boxes beside the path");
  left_out(r.twice, "rays of an element that another ray has");
  left_out(r.echoes, "further returns of a ray");
  left_out(r.points.unplaced, "points on no ray of the table");
  left_out(r.points.echoes, "second points of a ray");
  if (r.rays > 0) std::cerr << fmt::format("{} of {} rays returned\n", r.returned, r.rays);
}

}  // namespace

void add_import_ncore(Command import, const Globals& globals) {
  const auto command = std::make_shared<NcoreCommand>();
  NcoreOptions& options = command->options;
  Command sub = import.command("ncore", "a sequence of NVIDIA's NCore 4: cameras, LiDARs, boxes");
  sub.option("PATH",
             options.sequence,
             ".zarr folder, .zarr.itar, a folder of several, or the .json that lists them")
      .required();
  sub.option("-o,--output", options.output, "log folder to write").required();

  sub.option(
         "--cameras",
         [command](const std::string& text) { command->options.cameras = split(text, ','); },
         "these alone, parted by commas")
      .shown_as("NAME,...", "all");
  sub.option(
         "--lidars",
         [command](const std::string& text) { command->options.lidars = split(text, ','); },
         "these alone, parted by commas")
      .shown_as("NAME,...", "all");
  sub.option("--lidar",
             command->tables,
             "NAME=SENSOR, of a LiDAR whose beams the file doesn't tell, built-in (hesai_pandar128) or a "
             "LiDAR file "
             "(simuli fit beams)")
      .one_at_a_time();
  sub.option("--rig-frame", options.rig_frame, "the vehicle's frame").with_default();
  sub.option("--world-frame", options.world_frame, "that the path is in").with_default();
  sub.run([command, &globals] {
    NcoreOptions asked = command->options;
    for (const std::string& text : command->tables) {
      const auto [name, sensor] = parted("--lidar", text, '=', "NAME");
      asked.tables[name] = lidar_table(sensor);
    }
    run_import<NcoreReport>(
        "ncore",
        globals,
        [&](const auto& progress, NcoreReport& r) { return import_ncore(asked, progress, r); },
        tell_ncore);
  });
}

}  // namespace simuli::cli
