#include <fmt/format.h>
#include <iostream>
#include <memory>

#include "host/cli/commands.hpp"
#include "host/cli/file_progress.hpp"
#include "host/cli/info.hpp"
#include "io/kitti.hpp"

namespace simuli::cli {
namespace {

/// What became of the recorded points, on stderr: it is about the import, not part of the log.
void print_report(const KittiReport& r) {
  const auto percent = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  std::cerr << fmt::format(
      "{} points, {} of them on no beam and left out ({:.3f} %); {:.1f} % of {} rays returned\n",
      r.points,
      r.unplaced,
      percent(r.unplaced, r.points),
      percent(r.returned, r.rays),
      r.rays);
}

void import_kitti_drive(const KittiOptions& options, const Globals& globals) {
  FileProgress progress("import kitti", globals);
  KittiReport report;
  const Log log = import_kitti(options, progress.callback(), &report);
  progress.finish();
  print_report(report);
  print_log(log, globals.json);
}

}  // namespace

void add_import(CLI::App& app, const Globals& globals) {
  CLI::App* import =
      app.add_subcommand("import", "turn a recorded drive of another format into a log folder");
  import->require_subcommand(1);

  const auto options = std::make_shared<KittiOptions>();
  CLI::App* kitti = import->add_subcommand("kitti", "KITTI raw drive: left colour camera, HDL-64E, oxts");
  kitti->add_option("DIR", options->drive, "folder of one drive, the calibration in its parent")->required();
  kitti->add_option("-o,--output", options->output, "log folder to write")->required();
  kitti->add_option(
      "--poses", options->poses, "JSON with world_from_velo per frame; default: poses from oxts");
  kitti->add_option("--tracking",
                    options->tracking,
                    "label file of the tracking benchmark with this drive's boxes: actors");
  kitti->add_flag("--no-poses", options->without_poses, "a rig at rest; simuli align finds the path")
      ->excludes("--poses");
  kitti->add_option("--beams", options->lidar, "LiDAR file (simuli fit beams); default: the built-in table");
  kitti->callback([options, &globals] { import_kitti_drive(*options, globals); });
}

}  // namespace simuli::cli
