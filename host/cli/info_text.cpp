#include <cmath>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>

#include "host/cli/base/json_text.hpp"
#include "host/cli/base/provenance.hpp"
#include "host/cli/info.hpp"
#include "host/scene/mounting.hpp"
#include "io/log/sensor_json.hpp"
#include "io/scene/sensor_rig.hpp"
#include "io/scene/training_json.hpp"

namespace simuli::cli {
namespace {

using Json = nlohmann::ordered_json;

double path_length_m(const Trajectory& trajectory) {
  double length = 0.0;
  const auto& poses = trajectory.poses();
  for (std::size_t i = 1; i < poses.size(); ++i) {
    length += (poses[i].pose.translation - poses[i - 1].pose.translation).norm();
  }
  return length;
}

Json trajectory_json(const Trajectory& t) {
  if (t.poses().empty()) return {{"poses", 0}};
  return {{"poses", t.poses().size()},
          {"start_s", t.start_s()},
          {"end_s", t.end_s()},
          {"length_m", path_length_m(t)}};
}

Json sensors_json(const SensorRig& rig) {
  Json sensors = Json::array();
  for (const Sensor& sensor : rig.sensors()) {
    sensors.push_back(
        std::visit([](const auto& file) { return simuli::to_json(file); }, sensor_file_of(sensor)));
  }
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
  return fmt::format("camera {:<16} {}, {} x {} px, focal {:.1f} x {:.1f} px, shutter {}",
                     c.name,
                     simuli::to_string(c.lens.kind()),
                     c.width,
                     c.height,
                     c.fx,
                     c.fy,
                     simuli::to_string(c.shutter));
}

/// As `simuli render --mount` takes it, to a micrometre.
std::string mount_line(const Mounting& m) {
  const auto rounded = [](double value) { return std::round(value * 1e6) / 1e6 + 0.0; };  // no -0
  return fmt::format("mounted at {},{},{},{},{},{}",
                     rounded(m.position_m.x()),
                     rounded(m.position_m.y()),
                     rounded(m.position_m.z()),
                     rounded(m.roll_deg),
                     rounded(m.pitch_deg),
                     rounded(m.yaw_deg));
}

std::string sensors_text(const std::vector<LogCamera>& cameras, const std::vector<LogLidar>& lidars) {
  std::string text;
  for (const LogCamera& c : cameras) {
    text +=
        fmt::format("  {}, {}\n", camera_line(c.model), mount_line(Mounting::of_camera(c.rig_from_camera)));
  }
  for (const LogLidar& l : lidars) {
    text += fmt::format("  {}, {}\n", lidar_line(l.model), mount_line(Mounting::of_lidar(l.rig_from_lidar)));
  }
  return text;
}

Json actors_json(const std::vector<Actor>& actors) {
  Json all = Json::array();
  for (const Actor& actor : actors) {
    all.push_back({{"name", actor.name},
                   {"kind", actor.kind},
                   {"size_m", {actor.size_m.x(), actor.size_m.y(), actor.size_m.z()}},
                   {"start_s", actor.track.front().time_s},
                   {"end_s", actor.track.back().time_s},
                   {"travel_m", actor.travel_m()}});
  }
  return all;
}

std::string actors_text(const std::vector<Actor>& actors) {
  std::string text;
  for (const Actor& actor : actors) {
    text +=
        fmt::format("  actor  {:<16} {}, {:.1f} x {:.1f} x {:.1f} m, {:.2f} to {:.2f} s, gets {:.1f} m far\n",
                    actor.name,
                    actor.kind,
                    actor.size_m.x(),
                    actor.size_m.y(),
                    actor.size_m.z(),
                    actor.track.front().time_s,
                    actor.track.back().time_s,
                    actor.travel_m());
  }
  return text;
}

std::string trajectory_text(const Trajectory& t) {
  if (t.poses().empty()) return "  no trajectory\n";
  return fmt::format("  trajectory {} poses, {:.2f} s, {:.1f} m\n",
                     t.poses().size(),
                     t.end_s() - t.start_s(),
                     path_length_m(t));
}

Json recorded_json(const FrameSpans& recorded) {
  Json all = Json::object();
  for (const auto& [sensor, spans] : recorded) {
    all[sensor] = {{"frames", spans.size()},
                   {"start_s", spans.front().time_start_s},
                   {"end_s", spans.back().time_end_s}};
  }
  return all;
}

std::string recorded_text(const FrameSpans& recorded) {
  std::string text;
  for (const auto& [sensor, spans] : recorded) {
    text += fmt::format("  frames {:<16} {}, {:.2f} to {:.2f} s\n",
                        sensor,
                        spans.size(),
                        spans.front().time_start_s,
                        spans.back().time_end_s);
  }
  return text;
}

std::string set_text(const char* name, const GaussianSet& set) {
  return fmt::format("  {} set {} particles, SH degree {}, {:.1f} MB\n",
                     name,
                     set.size(),
                     set.sh_degree,
                     static_cast<double>(set.params.size()) * sizeof(float) / 1e6);
}

void print(const Json& json) { std::cout << json_text(json) << '\n'; }

}  // namespace

void print_log(const Log& log, bool json) {
  if (json) {
    return print({{"kind", "log"},
                  {"name", log.name},
                  {"start_ns", log.start_ns},
                  {"images", log.images.size()},
                  {"sweeps", log.sweeps.size()},
                  {"trajectory", trajectory_json(log.world_from_rig)},
                  {"sensors", sensors_json(SensorRig(log))},
                  {"actors", actors_json(log.actors)}});
  }
  std::cout << fmt::format("log {}\n  {} images, {} sweeps\n", log.name, log.images.size(), log.sweeps.size())
            << trajectory_text(log.world_from_rig) << sensors_text(log.cameras, log.lidars)
            << actors_text(log.actors);
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
                  {"sensors", sensors_json(SensorRig(file))},
                  {"recorded_frames", recorded_json(file.recorded_frames)},
                  {"actors", actors_json(scene.actors)},
                  {"training", file.training ? simuli::to_json(*file.training) : Json()}});
  }
  std::cout << fmt::format("scene {}\n", scene.name) << set_text("camera", scene.camera)
            << set_text("lidar", scene.lidar) << trajectory_text(file.world_from_rig)
            << sensors_text(file.cameras, file.lidars) << recorded_text(file.recorded_frames)
            << actors_text(scene.actors);
  if (!file.training) return;
  std::cout << "  trained\n";
  for (const RecordLine& line : record_lines(*file.training)) {
    std::cout << fmt::format("    {:<16} {}\n", line.name, line.value);
  }
}

void print_sensor(const CameraFile& file, bool json) {
  if (json) return print(simuli::to_json(file));
  const Camera& camera = file.model;
  std::cout << camera_line(camera) << '\n'
            << fmt::format("  centre {:.2f}, {:.2f} px\n", camera.cx, camera.cy);
  const auto& names = lens_parameter_names(camera.lens.kind());
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::cout << fmt::format("  {} {}\n", names[i], camera.lens.parameters()[i]);
  }
  const double pixels = static_cast<double>(camera.width) * camera.height;
  const std::size_t missing = pixels_without_ray(camera);
  std::cout << fmt::format(
      "  {} pixels without a ray, {:.2f} %\n", missing, 100.0 * static_cast<double>(missing) / pixels);
  if (file.readout_s > 0.0) std::cout << fmt::format("  read out in {} s\n", file.readout_s);
  std::cout << origin_text(file.source, file.licence, file.note);
}

std::string origin_text(const std::string& source, const std::string& licence, const std::string& note) {
  std::string text;
  if (!source.empty()) text += fmt::format("  source {}\n", source);
  if (!licence.empty()) text += fmt::format("  licence {}\n", licence);
  if (!note.empty()) text += fmt::format("  note {}\n", note);
  return text;
}

}  // namespace simuli::cli
