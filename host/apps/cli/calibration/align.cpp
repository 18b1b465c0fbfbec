#include "optim/calibration/path/align.hpp"

#include <cmath>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/counted.hpp"
#include "host/apps/cli/base/file_progress.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/progress.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "io/base/output.hpp"
#include "io/log/log_json.hpp"
#include "optim/calibration/camera/camera_pose.hpp"

namespace simuli::cli {
namespace {

namespace calib = simuli::calibration;

struct AlignCommand {
  std::string log;
  std::string output;
  calib::AlignOptions align;
  double prior_deg = 0.2;
  bool keep_path = false;
  std::vector<std::string> cameras;
  bool apply_cameras = false;
};

struct CameraResult {
  std::string name;
  std::optional<calib::CameraPoseReport> report;  // empty: the data do not determine it
  std::string reason;
};

const char* spin_name(SpinDirection spin) {
  return spin == SpinDirection::kClockwise ? "clockwise" : "counter_clockwise";
}

Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(const calib::Fit& fit) {
  return {
      {"median_m", fit.median_m}, {"planar_share", fit.planar_share}, {"outlier_share", fit.outlier_share}};
}

Json to_json(const calib::AlignReport& r) {
  Json json = {{"sweeps", r.sweeps},
               {"returns", r.returns},
               {"length_m", r.length_m},
               {"point_to_plane",
                {{"recorded_poses", to_json(r.recorded)},
                 {"odometry", to_json(r.odometry)},
                 {"refined", to_json(r.refined)}}},
               {"planes", r.refinement.planes},
               {"residuals", r.refinement.residuals},
               {"point_sigma_m", r.refinement.sigma_m},
               {"step_sigma_m", r.refinement.step_sigma_m},
               {"step_sigma_deg", r.refinement.step_sigma_rad / kDegree},
               {"seconds", r.seconds}};
  json["spin"] = {{"direction", r.spin.spin ? Json(spin_name(*r.spin.spin)) : Json(nullptr)},
                  {"clockwise_m", json_number(r.spin.clockwise_m)},
                  {"counter_clockwise_m", json_number(r.spin.counter_clockwise_m)},
                  {"reason", r.spin.reason}};
  return json;
}

Json to_json(const CameraResult& result) {
  if (!result.report) return {{"name", result.name}, {"determined", false}, {"reason", result.reason}};
  const calib::CameraPoseReport& r = *result.report;
  const auto array = [](const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); };
  return {{"name", result.name},
          {"determined", true},
          {"as_given", r.as_given},
          {"rig_from_camera", simuli::to_json(r.rig_from_camera)},
          {"time_offset_s", r.time_known ? Json(r.time_offset_s) : Json(nullptr)},
          {"translation_change_m", array(r.translation_change_m)},
          {"rotation_change_deg", r.rotation_change_rad / kDegree},
          {"translation_sigma_m", array(r.translation_sigma_m)},
          {"rotation_sigma_deg", array(r.rotation_sigma_rad / kDegree)},
          {"time_sigma_s", r.time_sigma_s},
          {"halves_apart_m", r.halves_apart_m ? array(*r.halves_apart_m) : Json(nullptr)},
          {"halves_apart_deg", r.halves_apart_rad ? array(*r.halves_apart_rad / kDegree) : Json(nullptr)},
          {"texture_pieces", r.pieces},
          {"texture_points", r.texture_points},
          {"texture_correlation_before", r.texture_before},
          {"texture_correlation_after", r.texture_after},
          {"edges", r.edges},
          {"matched", r.matched},
          {"outlier_share", r.outlier_share},
          {"before_px", r.before_px},
          {"after_px", r.after_px},
          {"notes", r.notes}};
}

std::string fit_line(const char* name, const calib::Fit& fit) {
  return fmt::format("  {:<18} {:>6.2f} cm   {:>5.1f} %   {:>5.2f} %\n",
                     name,
                     100.0 * fit.median_m,
                     100.0 * fit.planar_share,
                     100.0 * fit.outlier_share);
}

std::string text_of(const calib::AlignReport& r) {
  std::string text = fmt::format("trajectory: {}, {}, {:.2f} m, {:.1f} s\n",
                                 counted(r.sweeps, "sweep"),
                                 counted(r.returns, "return"),
                                 r.length_m,
                                 r.seconds);
  text += "  poses              median      on planes  beyond 10 cm\n";
  text +=
      fit_line("recorded", r.recorded) + fit_line("odometry", r.odometry) + fit_line("refined", r.refined);
  text += fmt::format(
      "  {} planes, {} distances; standard deviation of a point {:.2f} cm, of a sweep's motion {:.2f} mm "
      "and {:.4f} deg\n",
      r.refinement.planes,
      r.refinement.residuals,
      100.0 * r.refinement.sigma_m,
      1e3 * r.refinement.step_sigma_m,
      r.refinement.step_sigma_rad / kDegree);
  if (r.spin.spin) {
    text += fmt::format("spin: {}, surfaces {:.2f} cm if clockwise, {:.2f} cm if not\n",
                        spin_name(*r.spin.spin),
                        100.0 * r.spin.clockwise_m,
                        100.0 * r.spin.counter_clockwise_m);
  } else if (!r.spin.reason.empty()) {
    text += "spin: not determined: " + r.spin.reason + "\n";
  }
  return text;
}

std::string text_of(const CameraResult& result) {
  if (!result.report) return result.reason + "\n";  // the reason contains the camera's name
  const calib::CameraPoseReport& r = *result.report;
  const auto row = [](const char* name, const Eigen::Vector3d& v, const char* unit) {
    return fmt::format("  {:<22} {:>9.4f} {:>9.4f} {:>9.4f} {}\n", name, v.x(), v.y(), v.z(), unit);
  };
  std::string text =
      fmt::format("camera {}: {} visible depth edges, {} on an edge of the picture, {:.1f} % outliers\n",
                  result.name,
                  r.edges,
                  r.matched,
                  100.0 * r.outlier_share);
  text +=
      fmt::format("  median distance        {:.2f} px before, {:.2f} px after\n", r.before_px, r.after_px);
  if (r.pieces > 0) {
    text += fmt::format(
        "  texture: {} returns on {} flat pieces; correlation {:.3f} after the edge fit, {:.3f} at the end\n",
        r.texture_points,
        r.pieces,
        r.texture_before,
        r.texture_after);
  }
  text += row("moved by (camera axes)", r.translation_change_m, "m");
  text += row("standard deviations", r.translation_sigma_m, "m");
  text += fmt::format("  {:<22} {:>9.4f} deg\n", "rotated by", r.rotation_change_rad / kDegree);
  text += row("standard deviations", r.rotation_sigma_rad / kDegree, "deg");
  if (r.halves_apart_m && r.halves_apart_rad) {
    text += row("halves apart", *r.halves_apart_m, "m");
    text += row("halves apart", *r.halves_apart_rad / kDegree, "deg");
  }
  if (r.time_known) {
    text += fmt::format("  {:<22} {:>9.3f} ms, standard deviation {:.3f} ms\n",
                        "clock: add to times",
                        1e3 * r.time_offset_s,
                        1e3 * r.time_sigma_s);
  }
  for (const std::string& note : r.notes) text += "  " + note + "\n";
  return text;
}

void apply(const CameraResult& result, Log& log) {
  if (!result.report) return;
  for (LogCamera& camera : log.cameras) {
    if (camera.model.name == result.name) camera.rig_from_camera = result.report->rig_from_camera;
  }
  for (ImageFrame& frame : log.images) {
    if (frame.camera != result.name) continue;
    frame.time_start_s += result.report->time_offset_s;
    frame.time_end_s += result.report->time_offset_s;
  }
  sort_by_time(log);
}

void print_result(const AlignCommand& command,
                  const Globals& globals,
                  const std::optional<calib::AlignReport>& report,
                  const std::vector<CameraResult>& cameras,
                  bool is_written) {
  if (globals.json) {
    Json json = Json::object();
    if (report) json["path"] = to_json(*report);
    if (!cameras.empty()) json["cameras"] = Json::array();
    for (const CameraResult& result : cameras) json["cameras"].push_back(to_json(result));
    if (is_written) json["log"] = command.output;
    std::cout << json_text(json) << '\n';
    return;
  }
  if (report) std::cout << text_of(*report);
  for (const CameraResult& result : cameras) std::cout << text_of(result);
  if (is_written) {
    std::cout << fmt::format("log {} written{}\n",
                             on_one_line(command.output),
                             !cameras.empty() && !command.apply_cameras ? ", cameras unchanged" : "");
  }
}

void align(const AlignCommand& command, const Globals& globals) {
  Log log = read_log(command.log);
  if (command.keep_path && command.cameras.empty()) {
    throw_usage_error("--keep-path", "no --camera", "at least one --camera");
  }
  if (command.apply_cameras && (command.cameras.empty() || command.output.empty())) {
    throw_usage_error("--apply-cameras", "no --camera or no --output", "both");
  }
  for (const std::string& name : command.cameras) (void)log.camera(name);
  if (!command.output.empty()) need_new_path(command.output);  // fails early, before minutes of work
  StageProgress progress(progress_style(globals));
  std::optional<calib::AlignReport> report;
  Trajectory path = log.world_from_rig;
  if (!command.keep_path) {
    calib::AlignOptions options = command.align;
    options.prior_sigma_rad = command.prior_deg * kDegree;
    report = calib::align_log(log, options, [&](const char* stage, std::size_t done, std::size_t total) {
      progress.update(stage, done, total);
    });
    path = Trajectory(report->path);
  }
  std::vector<CameraResult> cameras;
  std::string refused;  // reasons; other results are still printed, and no log is written
  for (const std::string& name : command.cameras) {
    const std::string lidar =
        command.align.lidar.empty() ? name_of(log.lidars.at(0).model) : command.align.lidar;
    CameraResult& result = cameras.emplace_back(CameraResult{name, {}, {}});
    try {
      result.report =
          calib::find_camera_pose(log, name, lidar, path, 60, {}, [&](std::size_t done, std::size_t total) {
            progress.update("camera " + name, done, total);
          });
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kNumeric) throw;
      result.reason = error.what();
      if (!refused.empty()) refused += "; ";
      refused += result.reason;
    }
  }
  progress.finish();
  if (command.apply_cameras) {
    for (const CameraResult& result : cameras) apply(result, log);
  }
  const bool is_written = !command.output.empty() && refused.empty();
  if (is_written) calib::write_aligned_log(log, path, command.output);
  print_result(command, globals, report, cameras, is_written);
  if (!refused.empty()) throw Error(ErrorKind::kNumeric, refused);
}

}  // namespace

void add_align(Command app, const Globals& globals) {
  const auto command = std::make_shared<AlignCommand>();
  Command sub =
      app.command("align", "estimate a log's trajectory from its LiDAR, and the poses of its cameras");
  sub.option("LOG", command->log, "log folder").required();
  sub.option("-o,--output", command->output, "log folder to write; default: report only");
  sub.option("--lidar", command->align.lidar, "name of the LiDAR; default: the log's first");
  sub.flag("--prior", command->align.use_prior, "use the log's poses (GNSS/IMU) as a prior");
  sub.option("--prior-position", command->align.prior_sigma_m, "their standard deviation, m")
      .positive()
      .with_default();
  sub.option("--prior-rotation", command->prior_deg, "their standard deviation, degrees")
      .positive()
      .with_default();
  sub.flag("--keep-path", command->keep_path, "use the log's trajectory; calibrate only cameras");
  sub.option("--camera", command->cameras, "estimate this camera's mounting and clock; may be repeated");
  sub.flag("--apply-cameras", command->apply_cameras, "also write the estimated camera poses and clocks");
  sub.run([command, &globals] { align(*command, globals); });
}

}  // namespace simuli::cli
