#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/core/sensors/camera.hpp"
#include "io/base/file.hpp"
#include "io/base/output.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "io/import/ros2/ros2_log.hpp"
#include "io/log/log.hpp"
#include "io/log/sensor_json.hpp"
#include "io/scene/sensor_rig.hpp"
#include "optim/calibration/beams/beams.hpp"
#include "optim/calibration/lens/lens_fit.hpp"
#include "optim/calibration/path/spin.hpp"

namespace simuli::cli {
namespace {

namespace calib = simuli::calibration;
namespace fs = std::filesystem;

struct BeamsCommand {
  std::string folder;
  std::string topic;  // topic of a recording
  std::string output;
  std::string name = "fitted";
  std::size_t most_sweeps = 16;
  double spin_hz = 10.0;
};

struct LensCommand {
  std::string target;
  std::string sensor;
  std::string model;
  std::string output;
};

std::vector<fs::path> sweep_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(folder, status)) {
    if (ending_of(entry.path()) == ".bin") files.push_back(entry.path());
  }
  if (status) throw_input_error(folder.string(), "folder", status.message(), "a readable folder");
  if (files.empty())
    throw_input_error(folder.string(), "sweeps", "none", "files NAME.bin of float32 x y z reflectance");
  std::sort(files.begin(), files.end());
  return files;
}

calib::RawSweep read_raw(const fs::path& file) {
  calib::RawSweep sweep;
  for (const kitti::Point& point : kitti::read_points(file, true)) sweep.push_back(point.position);
  return sweep;
}

constexpr std::size_t kSpinSweeps = 10;

/// Sweeps for a fit: consecutive sweeps from the start, and sweeps spread over the drive.
struct RawSweeps {
  std::vector<calib::RawSweep> first, spread;
};

RawSweeps read_sweeps(const BeamsCommand& command) {
  const std::size_t most = std::max<std::size_t>(1, command.most_sweeps);
  if (!command.topic.empty()) {
    Ros2Clouds clouds = read_ros2_clouds(command.folder, command.topic, kSpinSweeps, most);
    return {std::move(clouds.first), std::move(clouds.spread)};
  }
  const std::vector<fs::path> files = sweep_files(command.folder);
  const std::size_t count = std::min(files.size(), most);
  RawSweeps sweeps;
  for (std::size_t i = 0; i < std::min(kSpinSweeps, files.size()); ++i)
    sweeps.first.push_back(read_raw(files[i]));
  for (std::size_t i = 0; i < count; ++i) sweeps.spread.push_back(read_raw(files[i * files.size() / count]));
  return sweeps;
}

/// Determines the spin direction from consecutive sweeps, with point times according to either direction.
calib::SpinReport spin_of(const std::vector<calib::RawSweep>& sweeps, double period_s) {
  constexpr double kVehicle_m = 2.0;
  std::vector<calib::Returns> clockwise;
  std::vector<calib::Returns> counter_clockwise;
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    calib::Returns one;
    one.time_start_s = static_cast<double>(s) * period_s;
    one.time_end_s = static_cast<double>(s + 1) * period_s;
    calib::Returns other = one;
    for (const Eigen::Vector3d& p : sweeps[s]) {
      if (!(p.norm() >= kVehicle_m)) continue;
      const double share = 0.5 - std::atan2(p.y(), p.x()) / (2.0 * std::numbers::pi);
      one.p_rig.push_back(p);
      one.time_s.push_back(one.time_start_s + share * period_s);
      other.p_rig.push_back(p);
      other.time_s.push_back(one.time_start_s + (1.0 - share) * period_s);
    }
    clockwise.push_back(std::move(one));
    counter_clockwise.push_back(std::move(other));
  }
  return calib::find_spin(clockwise, counter_clockwise);
}

std::string row_line(std::size_t i, const calib::BeamEstimate& b) {
  const auto known = [](bool is_known, const std::string& text) {
    return is_known ? text : std::string("-");
  };
  return fmt::format("{:>4} {:>9.4f} {:>7.4f} {:>9.1f} {:>6.2f} {:>9} {:>9} {:>8} {:>8.3f}\n",
                     i,
                     b.row.elevation / kDegree,
                     b.elevation_sigma / kDegree,
                     1e3 * b.row.vertical_offset,
                     1e3 * b.vertical_offset_sigma,
                     known(b.horizontal_offset_known, fmt::format("{:.1f}", 1e3 * b.row.horizontal_offset)),
                     known(b.azimuth_offset_known, fmt::format("{:.3f}", b.row.azimuth_offset / kDegree)),
                     b.points,
                     1e3 * b.residual);
}

void fit_beams(const BeamsCommand& command, const Globals& globals) {
  if (!command.output.empty()) need_writable(command.output);
  const RawSweeps sweeps = read_sweeps(command);
  const std::size_t count = sweeps.spread.size();
  const calib::BeamTable table = calib::find_beams(sweeps.spread);
  const calib::SpinReport spin = sweeps.first.size() >= 2 ? spin_of(sweeps.first, 1.0 / command.spin_hz)
                                                          : calib::SpinReport{{}, 0, 0, "only one sweep"};
  LidarFile file{calib::lidar_of(table, command.name, spin.spin.value_or(SpinDirection::kClockwise)), {}};
  file.facts.note = fmt::format("fitted to {} sweeps of bare points{}",
                                count,
                                spin.spin ? "" : "; spin direction not determined: clockwise assumed");
  std::get<Lidar>(file.model).sweep_s = 1.0 / command.spin_hz;
  if (!command.output.empty()) write_sensor_file(command.output, file);
  if (globals.json) {
    Json json = to_json(file);
    json["encoder_ticks"] = table.encoder_ticks;
    json["firings_per_turn"] = table.columns;
    json["returned_share"] = table.returned_share;
    json["unplaced"] = table.unplaced;
    json["near"] = table.near;
    json["notes"] = table.notes;
    json["sigmas"] = Json::array();
    for (const calib::BeamEstimate& b : table.rows) {
      json["sigmas"].push_back({{"elevation_rad", b.elevation_sigma},
                                {"vertical_offset_m", b.vertical_offset_sigma},
                                {"residual_rad", b.residual}});
    }
    std::cout << json_text(json) << '\n';
    return;
  }
  std::cout << fmt::format(
                   "{} beams from {} points of {} sweeps; unused points: {} on no beam, {} nearer than {} m, "
                   "too near for a fit\n",
                   table.rows.size(),
                   table.points,
                   count,
                   table.unplaced,
                   table.near,
                   calib::kNearestTelling_m)
            << " row  elevation  sigma  vertical  sigma horizontal  azimuth   points residual\n"
               "           deg    deg        mm     mm        mm      deg              mrad\n";
  for (std::size_t i = 0; i < table.rows.size(); ++i) std::cout << row_line(i, table.rows[i]);
  std::cout << fmt::format(
      "{:.1f} firings per turn, a step of {:.4f} deg; encoder of {} ticks; {:.1f} % of firings returned "
      "nothing\n",
      table.columns,
      table.columns > 0.0 ? 360.0 / table.columns : 0.0,
      table.encoder_ticks,
      100.0 * (1.0 - table.returned_share));
  if (spin.spin) {
    std::cout << fmt::format("spin: {}, surfaces {:.2f} cm thick if clockwise, {:.2f} cm if not\n",
                             *spin.spin == SpinDirection::kClockwise ? "clockwise" : "counter_clockwise",
                             100.0 * spin.clockwise_m,
                             100.0 * spin.counter_clockwise_m);
  } else {
    std::cout << "spin: not determined: " << spin.reason << '\n';
  }
  for (const std::string& note : table.notes) std::cout << note << '\n';
  if (!command.output.empty()) std::cout << fmt::format("sensor {} written\n", on_one_line(command.output));
}

Camera camera_by_name(const LensCommand& command) {
  std::error_code ignored;
  if (!fs::is_regular_file(fs::path(command.target) / "log.json", ignored)) {
    if (!command.sensor.empty()) {
      throw_input_error(command.target, "folder", "no log.json", "a log folder before a camera's name");
    }
    return named_sensor(command.target).camera();
  }
  const Log log = read_log(command.target);
  if (command.sensor.empty()) {
    throw_usage_error("SENSOR", "none", "a camera of " + command.target);
  }
  return log.camera(command.sensor).model;
}

void fit_lens(const LensCommand& command, const Globals& globals) {
  if (!command.output.empty()) need_writable(command.output);
  const LensKind kind = [&] {
    try {
      return lens_from_string(command.model, "--model", "lens");
    } catch (const Error& error) {
      throw Error(ErrorKind::kUsage, error.what());
    }
  }();
  const Camera source = camera_by_name(command);
  const calib::LensFit fit = calib::fit_lens(source, kind);
  CameraFile file{fit.camera};
  file.note = fmt::format("fitted to {}, RMS {:.4f} px", to_string(source.lens.kind()), fit.rms_px);
  if (!command.output.empty()) write_sensor_file(command.output, file);
  if (globals.json) {
    std::cout << json_text(Json{{"camera", to_json(file)},
                                {"rms_px", fit.rms_px},
                                {"largest_px", fit.largest_px},
                                {"largest_at_px", {fit.largest_at.x(), fit.largest_at.y()}},
                                {"uncovered_share", fit.uncovered_share},
                                {"samples", fit.samples},
                                {"checked", fit.checked}})
              << '\n';
    return;
  }
  std::cout << fmt::format("camera {}: {} as {}\n", source.name, to_string(source.lens.kind()), command.model)
            << fmt::format("  focal {:.4f} x {:.4f} px, centre {:.4f}, {:.4f} px\n",
                           fit.camera.fx,
                           fit.camera.fy,
                           fit.camera.cx,
                           fit.camera.cy);
  const auto& names = lens_parameter_names(kind);
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::cout << fmt::format("  {} {:.10g}\n", names[i], fit.camera.lens.parameters()[i]);
  }
  std::cout << fmt::format(
      "  {} rays fitted, {} others checked: RMS {:.4f} px, largest {:.4f} px at ({:.1f}, {:.1f})\n",
      fit.samples,
      fit.checked,
      fit.rms_px,
      fit.largest_px,
      fit.largest_at.x(),
      fit.largest_at.y());
  if (fit.uncovered_share > 0.0) {
    std::cout << fmt::format("  {:.2f} % of the picture has no image in this model\n",
                             100.0 * fit.uncovered_share);
  }
  if (!command.output.empty()) std::cout << fmt::format("camera {} written\n", on_one_line(command.output));
}

}  // namespace

void add_fit(Command app, const Globals& globals) {
  Command fit = app.command("fit", "fit a sensor model to data or to another model");
  fit.require_command();

  const auto beams = std::make_shared<BeamsCommand>();
  Command table = fit.command("beams", "estimate the beam table of a spinning LiDAR from its points");
  table
      .option("DIR",
              beams->folder,
              "folder of sweeps (*.bin, float32 x y z reflectance), or with --topic a recording of ROS 2")
      .required();
  table.option("--topic", beams->topic, "topic of the clouds of a recording; the vehicle may move");
  table.option("-o,--output", beams->output, "LiDAR file to write");
  table.option("--name", beams->name, "name of the sensor").with_default();
  table.option("--sweeps", beams->most_sweeps, "maximum number of sweeps, evenly spaced").with_default();
  table.option("--spin-hz", beams->spin_hz, "revolutions per second, for the spin direction")
      .range(0.1, 1000.0)
      .with_default();
  table.run([beams, &globals] { fit_beams(*beams, globals); });

  const auto lens = std::make_shared<LensCommand>();
  Command model = fit.command("lens", "convert a camera to another lens model");
  model.option("TARGET", lens->target, "built-in camera, camera file, or a log").required();
  model.option("SENSOR", lens->sensor, "camera of that log");
  model.option("--model", lens->model, "lens to fit: opencv_fisheye, ftheta_angle_to_radius, ...").required();
  model.option("-o,--output", lens->output, "camera file to write");
  model.run([lens, &globals] { fit_lens(*lens, globals); });
}

}  // namespace simuli::cli
