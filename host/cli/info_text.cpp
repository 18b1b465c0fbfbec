#include <algorithm>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "host/cli/info.hpp"

namespace simuli::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

double path_length_m(const Trajectory& trajectory) {
  double length = 0.0;
  const auto& poses = trajectory.poses();
  for (std::size_t i = 1; i < poses.size(); ++i) {
    length += (poses[i].pose.translation - poses[i - 1].pose.translation).norm();
  }
  return length;
}

const char* to_string(SpinDirection spin) {
  return spin == SpinDirection::kClockwise ? "clockwise" : "counter_clockwise";
}

Json camera_json(const Camera& c) {
  return {{"kind", "camera"},
          {"name", c.name},
          {"width_px", c.width},
          {"height_px", c.height},
          {"fx_px", c.fx},
          {"fy_px", c.fy},
          {"cx_px", c.cx},
          {"cy_px", c.cy},
          {"shutter", simuli::to_string(c.shutter)}};
}

Json lidar_json(const Lidar& l) {
  Json rows = Json::array();
  for (const LidarRow& row : l.rows) {
    rows.push_back({{"elevation_rad", row.elevation},
                    {"azimuth_offset_rad", row.azimuth_offset},
                    {"vertical_offset_m", row.vertical_offset},
                    {"horizontal_offset_m", row.horizontal_offset},
                    {"time_offset_s", row.time_offset}});
  }
  return {{"kind", "lidar"},
          {"name", l.name},
          {"columns", l.columns},
          {"azimuth_first_rad", l.azimuth_first},
          {"azimuth_span_rad", l.azimuth_span},
          {"spin", to_string(l.spin)},
          {"range_min_m", l.range_min},
          {"range_max_m", l.range_max},
          {"beam_divergence_rad", l.beam_divergence},
          {"divergence_variance", l.divergence_variance},
          {"rows", rows}};
}

Json trajectory_json(const Trajectory& t) {
  if (t.poses().empty()) return {{"poses", 0}};
  return {{"poses", t.poses().size()},
          {"start_s", t.start_s()},
          {"end_s", t.end_s()},
          {"length_m", path_length_m(t)}};
}

Json sensors_json(const std::vector<LogCamera>& cameras, const std::vector<LogLidar>& lidars) {
  Json sensors = Json::array();
  for (const LogCamera& camera : cameras) sensors.push_back(camera_json(camera.model));
  for (const LogLidar& lidar : lidars) sensors.push_back(lidar_json(lidar.model));
  return sensors;
}

Json set_json(const GaussianSet& set) {
  Json json = {{"particles", set.size()},
               {"sh_degree", set.sh_degree},
               {"parameter_bytes", set.params.size() * static_cast<Eigen::Index>(sizeof(float))}};
  if (set.size() > 0) {
    const Eigen::RowVector3f low = set.mean().colwise().minCoeff();
    const Eigen::RowVector3f high = set.mean().colwise().maxCoeff();
    json["mean_min_m"] = {low.x(), low.y(), low.z()};
    json["mean_max_m"] = {high.x(), high.y(), high.z()};
  }
  return json;
}

std::string camera_line(const Camera& c) {
  return fmt::format("camera {:<16} {} x {} px, focal {:.1f} x {:.1f} px, shutter {}",
                     c.name,
                     c.width,
                     c.height,
                     c.fx,
                     c.fy,
                     simuli::to_string(c.shutter));
}

std::string lidar_line(const Lidar& l) {
  const auto [low, high] =
      std::minmax_element(l.rows.begin(), l.rows.end(), [](const LidarRow& a, const LidarRow& b) {
        return a.elevation < b.elevation;
      });
  return fmt::format("lidar  {:<16} {} rows x {} columns, elevation {:.2f} to {:.2f} deg, {}, {} to {} m",
                     l.name,
                     l.row_count(),
                     l.columns,
                     low->elevation * kDegPerRad,
                     high->elevation * kDegPerRad,
                     to_string(l.spin),
                     l.range_min,
                     l.range_max);
}

std::string sensors_text(const std::vector<LogCamera>& cameras, const std::vector<LogLidar>& lidars) {
  std::string text;
  for (const LogCamera& camera : cameras) text += "  " + camera_line(camera.model) + "\n";
  for (const LogLidar& lidar : lidars) text += "  " + lidar_line(lidar.model) + "\n";
  return text;
}

std::string trajectory_text(const Trajectory& t) {
  if (t.poses().empty()) return "  no trajectory\n";
  return fmt::format("  trajectory {} poses, {:.2f} s, {:.1f} m\n",
                     t.poses().size(),
                     t.end_s() - t.start_s(),
                     path_length_m(t));
}

std::string set_text(const char* name, const GaussianSet& set) {
  return fmt::format("  {} set {} particles, SH degree {}, {:.1f} MB\n",
                     name,
                     set.size(),
                     set.sh_degree,
                     static_cast<double>(set.params.size()) * sizeof(float) / 1e6);
}

void print(const Json& json) { std::cout << json.dump(2) << '\n'; }

}  // namespace

void print_log(const Log& log, bool json) {
  if (json) {
    return print({{"kind", "log"},
                  {"name", log.name},
                  {"start_ns", log.start_ns},
                  {"images", log.images.size()},
                  {"sweeps", log.sweeps.size()},
                  {"trajectory", trajectory_json(log.world_from_rig)},
                  {"sensors", sensors_json(log.cameras, log.lidars)}});
  }
  std::cout << fmt::format("log {}\n  {} images, {} sweeps\n", log.name, log.images.size(), log.sweeps.size())
            << trajectory_text(log.world_from_rig) << sensors_text(log.cameras, log.lidars);
}

void print_scene(const SceneFile& file, bool json) {
  const Scene& scene = file.scene;
  if (json) {
    return print({{"kind", "scene"},
                  {"name", scene.name},
                  {"origin_m", {scene.origin.x(), scene.origin.y(), scene.origin.z()}},
                  {"camera_set", set_json(scene.camera)},
                  {"lidar_set", set_json(scene.lidar)},
                  {"trajectory", trajectory_json(file.world_from_rig)},
                  {"sensors", sensors_json(file.cameras, file.lidars)}});
  }
  std::cout << fmt::format("scene {}\n", scene.name) << set_text("camera", scene.camera)
            << set_text("lidar", scene.lidar) << trajectory_text(file.world_from_rig)
            << sensors_text(file.cameras, file.lidars);
}

void print_camera(const Camera& camera, bool json) {
  if (json) return print(camera_json(camera));
  std::cout << camera_line(camera) << '\n'
            << fmt::format("  centre {:.2f}, {:.2f} px\n", camera.cx, camera.cy);
}

void print_lidar(const Lidar& lidar, bool json) {
  if (json) return print(lidar_json(lidar));
  std::cout
      << lidar_line(lidar) << '\n'
      << fmt::format("  azimuth from {:.3f} deg over {:.3f} deg, divergence {} rad\n",
                     lidar.azimuth_first * kDegPerRad,
                     lidar.azimuth_span * kDegPerRad,
                     lidar.beam_divergence)
      << "  row  elevation_deg  azimuth_offset_deg  vertical_offset_m  horizontal_offset_m  time_offset_us\n";
  for (std::size_t i = 0; i < lidar.rows.size(); ++i) {
    const LidarRow& row = lidar.rows[i];
    std::cout << fmt::format("  {:3}  {:13.4f}  {:18.4f}  {:17.4f}  {:19.4f}  {:14.2f}\n",
                             i,
                             row.elevation * kDegPerRad,
                             row.azimuth_offset * kDegPerRad,
                             row.vertical_offset,
                             row.horizontal_offset,
                             row.time_offset * 1e6);
  }
}

}  // namespace simuli::cli
