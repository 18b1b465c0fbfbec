#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/edits.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/import/run_import.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/scene/placement.hpp"
#include "io/base/output.hpp"
#include "io/import/kitti/kitti.hpp"
#include "io/import/kitti360/kitti360.hpp"
#include "io/import/nuscenes/nuscenes.hpp"
#include "io/import/photos/photo_log.hpp"
#include "io/import/points/points_log.hpp"
#include "io/import/waymo/waymo.hpp"
#include "io/scene/splat_scene.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli::cli {
namespace {

using Lines = std::vector<std::string>;

/// Returns a line with the numbers of recorded points and rays.
std::string beams_line(const KittiReport& r) {
  const auto percent = [](std::size_t part, std::size_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  return fmt::format("{} points; left out: {} on no beam ({:.3f} %); {:.1f} % of {} rays returned",
                     r.points,
                     r.unplaced,
                     percent(r.unplaced, r.points),
                     percent(r.returned, r.rays),
                     r.rays);
}

Lines print_kitti(const KittiReport& r) {
  Lines lines;
  for (const KittiGaps& gaps : r.gaps) {
    lines.push_back(fmt::format("{}: nothing recorded in {} of the frames: {}",
                                gaps.sensor,
                                gaps.frames.size(),
                                runs_text(gaps.frames)));
  }
  for (const KittiGaps& gaps : r.disordered) {
    lines.push_back(fmt::format("{}: the time decreases; left out: {} frames: {}",
                                gaps.sensor,
                                gaps.frames.size(),
                                runs_text(gaps.frames)));
  }
  for (const KittiJump& jump : r.jumps)
    lines.push_back(fmt::format("{}: gap of {:.3g} s before frame {}", jump.sensor, jump.step_s, jump.frame));
  lines.push_back(beams_line(r));
  return lines;
}

Lines print_kitti360(const Kitti360Report& r) {
  return {fmt::format("{} pictures and sweeps are missing, {} without a pose", r.absent, r.unposed),
          beams_line(r.points)};
}

Lines print_photos(const PhotoReport& r) {
  Lines lines{fmt::format("{} photographs ({} listed but missing), {} points, {:.4g} m per unit",
                          r.photos,
                          r.absent,
                          r.points,
                          r.metres_per_unit)};
  lines.insert(lines.end(), r.notes.begin(), r.notes.end());
  return lines;
}

/// Adds options and the run function for posed photographs.
template <class Options, class Run>
void add_photos(Command command,
                const char* name,
                const std::shared_ptr<Options>& options,
                const Globals& globals,
                const Run& run) {
  command
      .option("--metres-per-unit",
              options->metres_per_unit,
              "scale of the model; default: points 10 m away, or steps of 0.5 m between photographs")
      .positive();
  add_run<PhotoReport>(command, name, options, globals, run, print_photos);
}

Lines print_nuscenes(const NuscenesReport& r) {
  Lines lines = r.hidden;
  lines.push_back(
      fmt::format("{} listed files are missing; {} of {} rays returned", r.absent, r.returned, r.rays));
  return lines;
}

Lines print_waymo(const WaymoReport& r) {
  return {fmt::format("{} frames; {} of {} rays returned", r.frames, r.returned, r.rays)};
}

Lines print_points(const PointReport& r) {
  Lines lines = r.notes;
  lines.push_back(points_line(r));
  return lines;
}

struct SplatCommand {
  std::string file, pose, axes = "y-down";
  std::filesystem::path output;
  bool is_survey = false;
  SplatPlacement placement;
};

void import_splats(SplatCommand command, const Globals& globals) {
  need_output(command.output, command.is_survey);
  if (!command.is_survey) need_new_path(command.output);
  if (command.axes == "y-up") command.placement.axes = SplatAxes::kYUp;
  if (command.axes == "z-up") command.placement.axes = SplatAxes::kZUp;
  if (!command.pose.empty())
    command.placement.world_from_model = parse_mounting("--pose", command.pose).rig_from_lidar();
  const SceneFile scene = scene_of_splats(command.file, command.placement);
  if (!command.is_survey) write_scene(command.output, scene);
  const Eigen::AlignedBox3d box = extent_of(scene.scene.camera);
  const Eigen::Vector3d size = box.sizes(), from = scene.scene.origin + box.min();
  for (const std::string& note : scene.splats.notes()) std::cerr << note << '\n';
  if (globals.json) {
    const nlohmann::ordered_json out = {{"folder", command.output},
                                        {"particles", scene.scene.camera.size()},
                                        {"left_out", scene.splats.left_out},
                                        {"sh_degree", scene.scene.camera.sh_degree},
                                        {"from_m", {from.x(), from.y(), from.z()}},
                                        {"size_m", {size.x(), size.y(), size.z()}}};
    std::cout << json_text(out) << '\n';
  } else {
    std::cout << fmt::format(
        "{} particles of SH degree {}, {:.2f} x {:.2f} x {:.2f} m from ({:.2f}, {:.2f}, {:.2f}) m on{}{}\n",
        scene.scene.camera.size(),
        scene.scene.camera.sh_degree,
        size.x(),
        size.y(),
        size.z(),
        from.x(),
        from.y(),
        from.z(),
        command.is_survey ? "" : ", in ",
        on_one_line(command.output.string()));
  }
}

}  // namespace

void need_output(std::filesystem::path& output, bool is_survey) {
  if (is_survey) output.clear();
  if (output.empty() && !is_survey) refuse("--output", "", "a folder to write, or --survey");
}

void add_label_line(const LabelReport& report, std::vector<std::string>& lines) {
  if (report.repeated == 0) return;
  lines.push_back(fmt::format("left out: {} of {} labels that repeat an actor and a time",
                              report.repeated,
                              report.kept + report.repeated));
}

void print_import(const Log& log, const std::vector<std::string>& notes, bool is_survey, bool json) {
  if (!is_survey || !json) {
    for (const std::string& note : notes) (is_survey ? std::cout : std::cerr) << on_one_line(note) << '\n';
  }
  if (json) {
    nlohmann::ordered_json out = log_json(log);
    out["notes"] = nlohmann::ordered_json::array();
    for (const std::string& note : notes) out["notes"].push_back(on_one_line(note));
    std::cout << json_text(out) << '\n';
  } else if (!is_survey || !log.world_from_rig.poses().empty()) {
    print_log(log, false);
  }
}

std::string points_line(const PointReport& r) {
  return fmt::format("{} points; left out: {} on no ray, {} second echoes; {} of {} rays returned",
                     r.points,
                     r.unplaced,
                     r.echoes,
                     r.returned,
                     r.rays);
}

std::string runs_text(const std::vector<std::size_t>& numbers) {
  constexpr int kMostRuns = 10;
  std::string text;
  int runs = 0;
  for (std::size_t i = 0; i < numbers.size() && runs <= kMostRuns; ++runs) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (runs > 0) text += ", ";
    if (runs == kMostRuns) return text + "and more";
    text += fmt::format("{}", numbers[i]);
    if (last > i) text += fmt::format(" to {}", numbers[last]);
    i = last + 1;
  }
  return text;
}

void add_import(Command app, const Globals& globals) {
  Command import =
      app.command("import", "convert a drive of another format to a log folder, or splats to a scene");
  import.require_command();

  const auto options = std::make_shared<KittiOptions>();
  Command kitti = import.command("kitti", "KITTI raw drive: cameras, HDL-64E, oxts");
  kitti.option("DIR", options->drive, "folder of one drive; its parent contains the calibration").required();
  kitti
      .option("--cameras",
              options->cameras,
              "comma-separated list of image_02 (left), image_03 (right), image_00 and image_01 (grey)")
      .comma_separated()
      .shown_as("NAME,...", "image_02");
  add_frames(kitti, options, "the drive's");
  kitti.option("--poses", options->poses, "JSON with world_from_velo per frame; default: poses from oxts");
  kitti.option("--tracking",
               options->tracking,
               "label file of the tracking benchmark with this drive's boxes, imported as actors");
  kitti
      .flag("--no-poses", options->without_poses, "store no ego poses; simuli align estimates the trajectory")
      .excludes("--poses");
  kitti.option("--beams", options->lidar, "LiDAR file (simuli fit beams); default: the built-in table");
  add_run<KittiReport>(
      kitti,
      "kitti",
      options,
      globals,
      [](const auto& requested, const auto& progress, KittiReport& r) {
        return import_kitti(requested, progress, &r);
      },
      print_kitti);

  const auto kitti360 = std::make_shared<Kitti360Options>();
  Command sequence =
      import.command("kitti360", "frames of KITTI-360: perspective and fisheye cameras, HDL-64E");
  sequence.option("DIR", kitti360->root, "folder of the data set: calibration, data_2d_raw ..").required();
  sequence.option(
      "--sequence", kitti360->sequence, "for example 2013_05_28_drive_0000_sync; default: the only sequence");
  add_frames(sequence, kitti360, "the sequence's");
  sequence.option("--beams", kitti360->lidar, "LiDAR file (simuli fit beams); default: KITTI's own table");
  add_run<Kitti360Report>(sequence, "kitti360", kitti360, globals, import_kitti360, print_kitti360);

  const auto nuscenes = std::make_shared<NuscenesOptions>();
  Command scene = import.command("nuscenes", "a scene of nuScenes: cameras, LIDAR_TOP, boxes");
  scene.option("DIR", nuscenes->root, "folder of the data set: tables, samples, sweeps").required();
  scene.option(
      "--version", nuscenes->version, "folder of tables, for example v1.0-mini; default: the only version");
  scene.option("--scene", nuscenes->scene, "for example scene-0061; default: the only scene");
  add_run<NuscenesReport>(scene, "nuscenes", nuscenes, globals, import_nuscenes, print_nuscenes);

  const auto waymo = std::make_shared<WaymoOptions>();
  Command segment = import.command("waymo", "a segment of the Waymo Open Dataset: cameras, LiDAR TOP, boxes");
  segment.option("FILE", waymo->segment, ".tfrecord of frames (Perception, version 1)").required();
  add_run<WaymoReport>(segment, "waymo", waymo, globals, import_waymo, print_waymo);

  add_import_pandaset(import, globals);
  add_import_ros2(import, globals);
  add_import_ncore(import, globals);

  const auto points = std::make_shared<PointsOptions>();
  Command bare =
      import.command("points", "a drive in a simple format: points.json, lists of points, pictures");
  bare.option("DIR", points->folder, "folder with points.json (format: io/import/points/points_log.hpp)")
      .required();
  add_run<PointReport>(bare, "points", points, globals, import_points, print_points);

  const auto colmap = std::make_shared<ColmapOptions>();
  Command sub = import.command("colmap", "a COLMAP model with its photographs");
  sub.option("DIR", colmap->model, "folder with cameras.bin or .txt, or the parent of its sparse/0")
      .required();
  sub.option("--images", colmap->images, "folder of the photographs; default: images, near the model");
  add_photos(sub, "colmap", colmap, globals, import_colmap);

  const auto nerfstudio = std::make_shared<NerfstudioOptions>();
  sub = import.command("nerfstudio", "posed photographs of a transforms.json");
  sub.option("FILE", nerfstudio->transforms, "transforms.json, or its folder").required();
  add_photos(sub, "nerfstudio", nerfstudio, globals, import_nerfstudio);

  const auto splat = std::make_shared<SplatCommand>();
  sub = import.command("splat", "a file of splats as a scene: .ply (also SuperSplat's compressed), .spz");
  sub.option("FILE",
             splat->file,
             "the LiDAR set receives the same particles, with intensity from their brightness")
      .required();
  add_output(sub, splat->output, splat->is_survey, "scene");
  sub.option("--axes", splat->axes, "up axis of the file").one_of({"y-down", "y-up", "z-up"}).with_default();
  sub.option("--metres-per-unit", splat->placement.metres_per_unit, "scale of the model").positive();
  sub.option("--pose", splat->pose, "X,Y,Z,ROLL,PITCH,YAW of the model in the world, m and degrees");
  sub.run([splat, &globals] { import_splats(*splat, globals); });
}

}  // namespace simuli::cli
