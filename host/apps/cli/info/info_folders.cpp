#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <iostream>
#include <nlohmann/json.hpp>

#include "host/apps/cli/base/counted.hpp"
#include "host/apps/cli/base/json_text.hpp"
#include "host/apps/cli/base/provenance.hpp"
#include "host/apps/cli/info/info.hpp"
#include "host/core/scene/mounting.hpp"
#include "host/core/scene/occluders.hpp"
#include "io/log/camera_mask.hpp"
#include "io/log/sensor_json.hpp"
#include "io/scene/scene_parts.hpp"
#include "io/scene/sensor_rig.hpp"

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

/// Returns the mounting in the format of `simuli render --mount`, rounded to a micrometre.
std::string mount_line(const Mounting& m) {
  const auto rounded = [](double value) { return std::round(value * 1e6) / 1e6 + 0.0; };  // no -0
  return fmt::format("mounted at {},{},{},{},{},{} (m, deg)",
                     rounded(m.position_m.x()),
                     rounded(m.position_m.y()),
                     rounded(m.position_m.z()),
                     rounded(m.roll_deg),
                     rounded(m.pitch_deg),
                     rounded(m.yaw_deg));
}

std::string recorded_text(const std::string& sensor, const FrameSpans& spans) {
  const auto found = spans.find(sensor);
  if (found == spans.end()) return {};
  const Recorded recorded = recorded_of(found->second);
  const std::string rate =
      recorded.rate_hz > 0.0 ? fmt::format(", {:.1f} per second", recorded.rate_hz) : std::string();
  return fmt::format("    {}{}, {:.2f} to {:.2f} s\n",
                     counted(recorded.frames, "frame"),
                     rate,
                     recorded.start_s,
                     recorded.end_s);
}

std::string sensors_text(const std::vector<LogCamera>& cameras,
                         const std::vector<LogLidar>& lidars,
                         const FrameSpans& spans) {
  std::string text;
  for (const LogCamera& c : cameras) {
    text += fmt::format("  {}, {}\n{}",
                        camera_line(c.model),
                        mount_line(Mounting::of_camera(c.rig_from_camera)),
                        recorded_text(c.model.name, spans));
  }
  for (const LogLidar& l : lidars) {
    text += fmt::format("  {}, {}\n{}",
                        lidar_line(l.model),
                        mount_line(Mounting::of_lidar(l.rig_from_lidar)),
                        recorded_text(name_of(l.model), spans));
  }
  return text;
}

Json recorded_json(const FrameSpans& spans) {
  Json all = Json::object();
  for (const auto& [sensor, frames] : spans) {
    const Recorded recorded = recorded_of(frames);
    all[sensor] = {{"frames", recorded.frames},
                   {"start_s", recorded.start_s},
                   {"end_s", recorded.end_s},
                   {"rate_hz", recorded.rate_hz}};
  }
  return all;
}

/// `log` is null for actors of a scene, which has no frames.
Json actors_json(const std::vector<Actor>& actors, const Trajectory& path, const Log* log) {
  Json all = Json::array();
  for (const Actor& actor : actors) {
    const Approach nearest = nearest_approach(actor, path);
    Json one = {{"name", actor.name},
                {"kind", actor.kind},
                {"size_m", {actor.size_m.x(), actor.size_m.y(), actor.size_m.z()}},
                {"start_s", actor.track.front().time_s},
                {"end_s", actor.track.back().time_s},
                {"poses", actor.track.size()},
                {"travel_m", actor.travel_m()},
                {"rigid", actor.deformation.empty()},
                {"nearest_m", nearest.is_found ? Json(nearest.distance_m) : Json()},
                {"nearest_s", nearest.is_found ? Json(nearest.time_s) : Json()}};
    if (log != nullptr) {
      const ActorFrames frames = frames_with(actor, *log);
      one["images"] = frames.images;
      one["sweeps"] = frames.sweeps;
    }
    all.push_back(std::move(one));
  }
  return all;
}

std::string actors_text(const std::vector<Actor>& actors, const Trajectory& path, const Log* log) {
  std::string text;
  for (const Actor& actor : actors) {
    text += fmt::format("  actor  {:<16} {}, {:.1f} x {:.1f} x {:.1f} m, {:.2f} to {:.2f} s",
                        actor.name,
                        actor.kind,
                        actor.size_m.x(),
                        actor.size_m.y(),
                        actor.size_m.z(),
                        actor.track.front().time_s,
                        actor.track.back().time_s);
    if (log != nullptr) {
      const ActorFrames frames = frames_with(actor, *log);
      text += fmt::format(" ({}, {})", counted(frames.images, "image"), counted(frames.sweeps, "sweep"));
    }
    text += fmt::format(", travels {:.1f} m", actor.travel_m());
    if (!actor.deformation.empty()) text += ", not rigid";
    const Approach nearest = nearest_approach(actor, path);
    if (nearest.is_found) {
      text += fmt::format(", nearest {:.1f} m at {:.2f} s", nearest.distance_m, nearest.time_s);
    }
    text += '\n';
  }
  return text;
}

std::size_t particles_of(const Scene& scene, std::uint32_t number) {
  std::size_t count = 0;
  for (const GaussianSet* const set : {&scene.camera, &scene.lidar}) {
    count += static_cast<std::size_t>(std::count(set->actor.begin(), set->actor.end(), number));
  }
  return count;
}

Json visibility_sets_json(const Scene& scene) {
  Json all = Json::array();
  for (std::size_t i = 0; i < scene.visibility_sets.size(); ++i) {
    all.push_back({{"particles", particles_of(scene, number_of_visibility_set(scene, i))}});
  }
  return all;
}

std::string visibility_sets_text(const Scene& scene) {
  if (scene.visibility_sets.empty()) return {};
  std::size_t particles = 0;
  for (std::size_t i = 0; i < scene.visibility_sets.size(); ++i)
    particles += particles_of(scene, number_of_visibility_set(scene, i));
  return fmt::format(
      "  {} visibility sets of chunks: {} particles\n", scene.visibility_sets.size(), particles);
}

Json occluders_json(const Scene& scene) {
  Json all = Json::array();
  const std::vector<Occluder> occluders = occluders_of(scene);
  for (std::size_t i = 0; i < occluders.size(); ++i) {
    Json occluder = {{"actor", occluders[i].actor->name},
                     {"behind", particles_of(scene, disoccluded_number(scene, i))},
                     {"instead", particles_of(scene, inpainted_number(scene, i))}};
    if (occluders[i].visibility_set) occluder["vista"] = *occluders[i].visibility_set;
    all.push_back(std::move(occluder));
  }
  return all;
}

std::string occluders_text(const Scene& scene) {
  std::string text;
  const std::vector<Occluder> occluders = occluders_of(scene);
  for (std::size_t i = 0; i < occluders.size(); ++i) {
    text += fmt::format("  occluder {}: {} disoccluded particles, {} inpainted particles\n",
                        occluders[i].actor->name,
                        particles_of(scene, disoccluded_number(scene, i)),
                        particles_of(scene, inpainted_number(scene, i)));
  }
  return text;
}

/// Returns the share hidden by masks of each camera's pictures.
Json hidden_json(const Log& log) {
  Json shares = Json::object();
  for (const auto& [camera, mask] : log.hidden) shares[camera] = mask->hidden_share();
  return shares;
}

std::string hidden_text(const Log& log) {
  std::string text;
  for (const auto& [camera, mask] : log.hidden)
    text += fmt::format("  {}: {:.1f} % hidden by masks\n", camera, 100.0 * mask->hidden_share());
  return text;
}

std::string trajectory_text(const Trajectory& t) {
  if (t.poses().empty()) return "  no trajectory\n";
  return fmt::format("  trajectory {} poses, {:.2f} s, {:.1f} m\n",
                     t.poses().size(),
                     t.end_s() - t.start_s(),
                     path_length_m(t));
}

void print(const Json& json) { std::cout << json_text(json) << '\n'; }

}  // namespace

Json log_json(const Log& log) {
  return {{"kind", "log"},
          {"name", log.name},
          {"start_ns", log.start_ns},
          {"images", log.images.size()},
          {"sweeps", log.sweeps.size()},
          {"trajectory", trajectory_json(log.world_from_rig)},
          {"sensors", sensors_json(SensorRig(log))},
          {"recorded_frames", recorded_json(frame_spans(log))},
          {"hidden_shares", hidden_json(log)},
          {"actors", actors_json(log.actors, log.world_from_rig, &log)}};
}

void print_log(const Log& log, bool json) {
  if (json) return print(log_json(log));
  std::cout << fmt::format("log {}\n  {}, {}\n",
                           log.name,
                           counted(log.images.size(), "image"),
                           counted(log.sweeps.size(), "sweep"))
            << trajectory_text(log.world_from_rig) << sensors_text(log.cameras, log.lidars, frame_spans(log))
            << hidden_text(log) << actors_text(log.actors, log.world_from_rig, &log);
}

void print_scene(const SceneFile& file, bool json) {
  const Scene& scene = file.scene;
  if (json) {
    return print({{"kind", "scene"},
                  {"name", scene.name},
                  {"origin_m", {scene.origin.x(), scene.origin.y(), scene.origin.z()}},
                  {"camera_set", set_json(scene.camera)},
                  {"lidar_set", set_json(scene.lidar)},
                  {"camera_filter_px2", scene.camera_filter_px2},
                  {"trajectory", trajectory_json(file.world_from_rig)},
                  {"sensors", sensors_json(SensorRig(file))},
                  {"recorded_frames", recorded_json(file.recorded_frames)},
                  {"actors", actors_json(scene.actors, file.world_from_rig, nullptr)},
                  {"vistas", visibility_sets_json(scene)},
                  {"occluders", occluders_json(scene)},
                  {"training", file.training ? simuli::to_json(*file.training) : Json()}});
  }
  std::cout << fmt::format("scene {}\n", scene.name) << set_text("camera", scene.camera)
            << set_text("lidar", scene.lidar)
            << fmt::format("  camera filter {:.4f} px2\n", scene.camera_filter_px2)
            << trajectory_text(file.world_from_rig)
            << sensors_text(file.cameras, file.lidars, file.recorded_frames)
            << actors_text(scene.actors, file.world_from_rig, nullptr) << visibility_sets_text(scene)
            << occluders_text(scene);
  if (!file.training) return;
  std::cout << "  trained\n";
  for (const RecordLine& line : record_lines(*file.training)) {
    std::cout << fmt::format("    {:<16} {}\n", line.name, line.value);
  }
  if (file.training->held_out) std::cout << text_of(*file.training->held_out);
}

}  // namespace simuli::cli
