#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/counted.hpp"
#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/scene/edit.hpp"
#include "io/base/file.hpp"
#include "io/base/output.hpp"
#include "io/export/drive_archive.hpp"
#include "io/log/log.hpp"
#include "io/ncore/ncore_export.hpp"
#include "io/scene/scene_clock.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli::cli {
namespace {

struct ExportCommand {
  std::string input;
  std::string output;
  Edits edits;
  double at_s = 0.0;
  bool is_moment = false;
  bool lidar = false;
  bool compress = false;
  bool drive = false;
};

SetKind kind_of(const ExportCommand& command) { return command.lidar ? SetKind::kLidar : SetKind::kCamera; }

/// Exported particles, and descriptions of the parts left out.
struct Export {
  GaussianSet set;
  SplatAxes axes = SplatAxes::kYDown;
  std::vector<std::string> left_out = {};
};

/// Reads a splat file without the rotation of read_scene().
Export of_splats(const ExportCommand& command) {
  if (command.is_moment || !lines_of(command.edits).empty()) {
    throw_usage_error("INPUT", "a splat file", "a scene for --at and edits");
  }
  if (command.lidar) return {read_gaussians_ply(command.input, SetKind::kLidar)};
  SplatReport report;
  Export out{read_splats(command.input, &report)};
  for (const std::string& note : report.notes()) std::cerr << fmt::format("simuli: note: {}\n", note);
  return out;
}

Export of_scene(const ExportCommand& command) {
  SceneFile file = read_scene_and_report(command.input);
  if (const Trajectory& path = file.world_from_rig; command.is_moment && !path.poses().empty()) {
    if (!(command.at_s >= path.start_s() && command.at_s <= path.end_s())) {
      throw_usage_error("--at",
                        fmt::format("{}", command.at_s),
                        fmt::format("{:.2f} to {:.2f}, the scene's time", path.start_s(), path.end_s()));
    }
  }
  apply(command.edits, file);
  const Scene& scene = file.scene;
  const GaussianSet& all = command.lidar ? scene.lidar : scene.camera;
  Export out{command.is_moment ? moment_of(scene, kind_of(command), command.at_s)
                               : background_of(scene, kind_of(command)),
             SplatAxes::kZUp};
  if (out.set.size() < all.size()) {
    out.left_out.push_back(
        fmt::format("{} particles of actors{}",
                    all.size() - out.set.size(),
                    command.is_moment ? " that are absent at this time" : " (--at TIME includes them)"));
  }
  if (!command.lidar && !scene.environment.empty()) out.left_out.emplace_back("the environment map");
  if (!command.lidar && !scene.color_grids.empty())
    out.left_out.emplace_back("colour transforms of pictures");
  return out;
}

void print_left_out(const std::vector<std::string>& left_out) {
  if (!left_out.empty()) std::cerr << fmt::format("simuli: note: left out: {}\n", fmt::join(left_out, ", "));
}

void export_drive(const ExportCommand& command, const Globals& globals) {
  SceneFile scene = read_scene_and_report(command.input);
  apply(command.edits, scene);
  const std::string id = scene_id_of(command.input);
  const DriveArchive archive = write_drive_archive(command.output, scene, id);
  std::vector<std::string> left_out;
  if (archive.ground_triangles == 0) left_out.emplace_back("the ground (no LiDAR points)");
  if (archive.cameras_without_model > 0) {
    left_out.push_back(fmt::format("the lenses of {} cameras", archive.cameras_without_model));
  }
  print_left_out(left_out);
  if (globals.json) {
    const nlohmann::ordered_json out = {{"file", command.output},
                                        {"scene_id", id},
                                        {"cameras", scene.cameras.size()},
                                        {"actors", archive.actors},
                                        {"ground_triangles", archive.ground_triangles}};
    std::cout << json_text(out) << '\n';
  } else {
    std::cout << fmt::format("scene {}: {}, {}, {} of ground in {}\n",
                             id,
                             counted(scene.cameras.size(), "camera"),
                             counted(archive.actors, "actor"),
                             counted(archive.ground_triangles, "triangle"),
                             on_one_line(command.output));
  }
}

/// Exports a log in the NCore format given by the extension of the output.
void export_log(const ExportCommand& command, const Globals& globals) {
  if (command.is_moment || command.drive || command.lidar || command.compress ||
      !lines_of(command.edits).empty()) {
    throw_usage_error("INPUT", "a log", "a scene for edits and these options");
  }
  const Log log = read_log(command.input);
  FileProgress progress("export", globals);
  const NcoreExport done = export_ncore(log, command.output, progress.callback());
  progress.finish();
  print_left_out(done.left_out);
  if (globals.json) {
    const nlohmann::ordered_json out = {{"file", command.output},
                                        {"pictures", done.pictures},
                                        {"sweeps", done.sweeps},
                                        {"boxes", done.boxes}};
    std::cout << json_text(out) << '\n';
  } else {
    std::cout << fmt::format("{}, {}, {} in {}\n",
                             counted(done.pictures, "picture"),
                             counted(done.sweeps, "sweep"),
                             counted(done.boxes, "box", "boxes"),
                             on_one_line(command.output));
  }
}

void run_export(const ExportCommand& command, const Globals& globals) {
  need_writable(command.output);
  if (is_there(std::filesystem::path(command.input) / "log.json")) return export_log(command, globals);
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(command.input, ignored);
  if (command.drive && is_folder) return export_drive(command, globals);
  if (command.drive) {
    throw_usage_error("--drive", "no scene folder", "a scene folder: other files have no trajectory");
  }
  const Export exported = is_folder ? of_scene(command) : of_splats(command);
  write_splats(command.output, exported.set, {exported.axes, command.compress});
  print_left_out(exported.left_out);
  if (globals.json) {
    const nlohmann::ordered_json out = {
        {"file", command.output}, {"particles", exported.set.size()}, {"sh_degree", exported.set.sh_degree}};
    std::cout << json_text(out) << '\n';
  } else {
    std::cout << fmt::format("{} particles of SH degree {} in {}\n",
                             exported.set.size(),
                             exported.set.sh_degree,
                             on_one_line(command.output));
  }
}

}  // namespace

void add_export(Command app, const Globals& globals) {
  const auto command = std::make_shared<ExportCommand>();
  Command sub = app.command("export", "convert a scene, a splat file or a log for other programs");
  sub.option("INPUT",
             command->input,
             "scene folder, .ply (also SuperSplat's compressed), .spz or .glb; a log folder for NCore")
      .required();
  sub.option("-o,--output",
             command->output,
             ".ply, .spz, .glb (glTF), .usda or .usdz (OpenUSD); for a log .zarr or .zarr.itar (NCore)")
      .required();
  const Option at =
      sub.option("--at", command->at_s, "include actors at this time, s of the log; default: without actors");
  sub.flag("--compress", command->compress, "in .glb: store particles as SPZ, a tenth of the size");
  sub.flag("--lidar", command->lidar, "export the LiDAR set instead of the camera set; only .ply");
  sub.flag("--drive",
           command->drive,
           "write a .usdz with trajectory, cameras, actors, road and ground, for AlpaSim and CARLA")
      .excludes("--at")
      .excludes("--compress")
      .excludes("--lidar");
  add_edit_options(sub, command->edits);
  sub.run([command, at, &globals] {
    command->is_moment = at.is_given();
    run_export(*command, globals);
  });
}

}  // namespace simuli::cli
