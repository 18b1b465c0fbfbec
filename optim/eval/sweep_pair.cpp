#include "optim/eval/sweep_pair.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "host/device/render/scene/readings.hpp"
#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"

namespace simuli {

bool is_met(const SweepPair& pair, std::size_t ray) {
  const RayResults& r = pair.simulated;
  return r.drop_probability(ray) < 0.5F &&
         std::abs(best_distance(r, ray) - pair.recorded.range[ray]) < SweepPair::kSame_m;
}

SweepPair render_sweep(SceneOnDevice& scene, const Log& log, const SweepFrame& frame) {
  const LidarModel& lidar = log.lidar(frame.lidar).model;
  SweepPair pair;
  pair.recorded = read_sweep(log, frame, lidar);
  const Sensor sensor = Sensor(lidar).with_rays(pair.recorded.rays);
  pair.simulated = scene.render(sensor, shot_of(log, frame)).results();
  return pair;
}

Log with_sensors_of(const SceneFile& scene, Log log) {
  for (LogCamera& camera : log.cameras) {
    const LogCamera* const known = scene.find_camera(camera.model.name);
    if (known != nullptr) camera.rig_from_camera = known->rig_from_camera;
  }
  for (LogLidar& lidar : log.lidars) {
    const LogLidar* const known = scene.find_lidar(name_of(lidar.model));
    if (known == nullptr) continue;
    lidar.rig_from_lidar = known->rig_from_lidar;
    const double farthest_m = range_max(known->model);
    std::visit([&](auto& model) { model.range_max = farthest_m; }, lidar.model);
    auto* const model = std::get_if<Lidar>(&lidar.model);
    if (model == nullptr) continue;
    const Lidar& trained = known->with_rows();
    model->blind = trained.blind;
    const std::size_t rows = std::min(model->rows.size(), trained.rows.size());
    for (std::size_t row = 0; row < rows; ++row) model->rows[row].range_bias = trained.rows[row].range_bias;
  }
  return log;
}

}  // namespace simuli
