#include "optim/eval/scene_sensors.hpp"

#include <algorithm>
#include <variant>

namespace simuli {

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
