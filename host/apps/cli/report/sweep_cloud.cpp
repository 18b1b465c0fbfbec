#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "host/apps/cli/draw/pictures.hpp"
#include "host/apps/cli/report/report_parts.hpp"
#include "io/scene/sensor_rig.hpp"
#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

/// LiDARs whose beams fire at different azimuths; the report uses the first that the log lacks.
constexpr std::array kOthers{"ouster_os1_128@1024x10", "hesai_xt32"};

CloudLayer layer_of(const std::string& name,
                    const char* colour,
                    const LidarModel& lidar,
                    const LidarFrame& frame,
                    const Shot& shot,
                    const Pose& rig_from_lidar) {
  CloudLayer layer{name, colour};
  const std::vector<Eigen::Vector3d> points = points_of(lidar, frame, shot, PointFrame::kSensorStart);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!frame.is_return(i)) continue;
    const Eigen::Vector3d p_rig = rig_from_lidar * points[i];
    for (const double value : p_rig) layer.xyz.push_back(static_cast<float>(value));
    layer.intensity.push_back(frame.intensity[i]);
  }
  return layer;
}

/// Returns the boxes of the actors that are present when the shot begins.
std::vector<CloudBox> boxes_of(const std::vector<Actor>& actors,
                               const Shot& shot,
                               const Pose& rig_from_lidar) {
  std::vector<CloudBox> boxes;
  const Pose rig_from_world = rig_from_lidar * shot.world_from_sensor_start.inverse();
  const std::vector<ActorView> views = actors_during(actors, shot, Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].is_there) continue;
    const Pose rig_from_actor = rig_from_world * views[i].scene_from_actor_start;
    CloudBox box;
    for (std::size_t k = 0; k < box.size(); ++k) {
      const Eigen::Vector3d sides(
          (k & 1) != 0 ? 0.5 : -0.5, (k & 2) != 0 ? 0.5 : -0.5, (k & 4) != 0 ? 0.5 : -0.5);
      const Eigen::Vector3d corner = rig_from_actor * Eigen::Vector3d(actors[i].size_m.cwiseProduct(sides));
      for (std::size_t axis = 0; axis < 3; ++axis)
        box[k][axis] = static_cast<float>(corner[static_cast<Eigen::Index>(axis)]);
    }
    boxes.push_back(box);
  }
  return boxes;
}

std::string other_than(const Log& log) {
  for (const char* name : kOthers) {
    const std::string model = std::string(name).substr(0, std::string(name).find('@'));
    const bool is_own = std::any_of(log.lidars.begin(), log.lidars.end(), [&](const LogLidar& l) {
      return name_of(l.model).find(model) != std::string::npos;
    });
    if (!is_own) return name;
  }
  return kOthers.front();
}

}  // namespace

void add_sweep_cloud(HtmlReport& html, Evaluation& evaluation, SceneOnDevice& scene) {
  const std::vector<std::size_t>& sweeps = evaluation.frames().sweeps;
  if (sweeps.empty() || scene.scene().lidar.size() == 0) return;
  const Log& log = evaluation.log();
  const std::size_t index = sweeps[sweeps.size() / 2];
  const SweepFrame& frame = log.sweeps[index];
  const LogLidar& lidar = log.lidar(frame.lidar);
  const Shot shot = shot_of(log, frame);
  const LidarPair pair = evaluation.sweep(index);
  const Sensor other = named_sensor(other_than(log)).mounted(lidar.rig_from_lidar);
  Shot other_shot = shot;
  other_shot.time_end_s = shot.time_start_s + other.duration_s();
  const double share =
      shot.time_end_s > shot.time_start_s ? other.duration_s() / (shot.time_end_s - shot.time_start_s) : 1.0;
  other_shot.world_from_sensor_end = shot.pose_at(share);
  const LidarFrame of_other = scene.render(other, other_shot).lidar();
  const std::string time = fmt::format("{:.2f} s", frame.time_start_s);
  html.heading("Points to turn");
  html.cloud(
      {layer_of("recorded", "#3f8cff", lidar.model, pair.recorded, shot, lidar.rig_from_lidar),
       layer_of("rendered", "#ff9a3d", lidar.model, pair.rendered, shot, lidar.rig_from_lidar),
       [&] {
         CloudLayer layer =
             layer_of(other.name(), "#5fd38a", other.lidar(), of_other, other_shot, lidar.rig_from_lidar);
         layer.is_shown = false;
         return layer;
       }()},
      boxes_of(scene.scene().actors, shot, lidar.rig_from_lidar),
      fmt::format("{}, sweep {}, {}, in the vehicle's frame when it began; boxes: actors. At most {} "
                  "points of each. Drag, or arrow keys: turn; Shift and drag: move; wheel (after a click), "
                  "+ and -, two fingers: nearer and farther.",
                  frame.lidar,
                  index,
                  time,
                  CloudLayer::kMostPoints));
  html.heading("Another LiDAR");
  html.paragraph("Rendered where the recorded one is; nothing was recorded to compare with.");
  html.picture(
      range_image(other.lidar(), of_other.rays, of_other.range),
      fmt::format("{}, {}: ranges of {} rays by azimuth, warm near, cold far; black: no return; grey: no ray",
                  other.name(),
                  time,
                  of_other.range.size()));
}

}  // namespace simuli::cli
