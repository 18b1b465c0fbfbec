#include "host/cli/base/train_settings.hpp"

#include <utility>

namespace simuli::cli {

std::vector<Setting> train_settings(TrainingOptions& options) {
  InitOptions& init = options.init;
  TrainOptions& train = options.train;
  std::vector<Setting> all = {
      {"init.voxel_m", &init.voxel_m},
      {"init.camera_sh_degree", &init.camera_sh_degree},
      {"init.lidar_sh_degree", &init.lidar_sh_degree},
      {"init.max_camera", &init.max_camera},
      {"init.max_lidar", &init.max_lidar},
      {"init.max_shell", &init.max_shell},
      {"init.shell_spacing_deg", &init.shell_spacing_deg},
      {"init.camera_scale", &init.camera_scale},
      {"init.lidar_scale", &init.lidar_scale},
      {"init.min_scale_m", &init.min_scale_m},
      {"init.max_scale_m", &init.max_scale_m},
      {"init.sweep_depth", &init.sweep_depth},
      {"init.sweep_cell_px", &init.sweep_cell_px},
      {"init.range_bias", &options.sensors.range_bias},
      {"init.own_vehicle", &options.sensors.own_vehicle},
      {"init.drop_moving", &init.drop_moving},
      {"init.environment_width", &init.environment_width},
      {"loss.colour_absolute", &train.image.absolute},
      {"loss.colour_squared", &train.image.squared},
      {"loss.ssim", &train.image.dissimilarity},
      {"loss.environment_variation", &train.look.environment_variation},
      {"loss.grid_variation", &train.look.grid_variation},
      {"loss.grid_drift", &train.look.grid_drift},
      {"camera.loss.scale", &train.camera_particles.scale},
      {"camera.loss.opacity", &train.camera_particles.opacity},
      {"camera.loss.entropy", &train.camera_particles.entropy},
      {"lidar.loss.scale", &train.lidar_particles.scale},
      {"lidar.loss.opacity", &train.lidar_particles.opacity},
      {"lidar.loss.entropy", &train.lidar_particles.entropy},
      {"color_grids", &train.look.color_grids},
      {"look.rate.environment", &train.look.environment_rate},
      {"look.rate.grid", &train.look.grid_rate},
      {"look.rate.final_share", &train.look.final_share},
      {"init.actors", &init.actors},
      {"init.actor_min_travel_m", &init.actor_min_travel_m},
      {"init.actor_voxel_m", &init.actor_voxel_m},
      {"init.actor_margin_m", &init.actor_margin_m},
      {"init.mirror_actors", &init.mirror_actors},
      {"init.register_tracks", &init.register_tracks},
      {"actors.rate.shift_m", &train.actor_poses.shift_m},
      {"actors.rate.turn_rad", &train.actor_poses.turn_rad},
      {"actors.rate.final_share", &train.actor_poses.final_share},
      {"actors.margin_m", &train.actor_margin_m},
      {"loss.distance", &train.weights.distance},
      {"loss.intensity", &train.weights.intensity},
      {"loss.drop", &train.weights.drop},
      {"anchor.weight", &train.anchor.weight},
      {"anchor.neighbours", &train.anchor.neighbours},
      {"anchor.every", &train.anchor.every},
      {"anchor.choose_every", &train.anchor.choose_every},
      {"anchor.reach_m", &train.anchor.reach_m},
      {"densify.every", &train.densify.every},
      {"densify.first", &train.densify.first},
      {"densify.last_share", &train.densify.last_share},
      {"densify.growth", &train.densify.growth},
      {"densify.cap", &train.densify.cap},
      {"densify.noise", &train.densify.noise},
      {"lidar_every", &train.lidar_every},
      {"mask_moving", &train.mask_moving},
      {"cache_bytes", &train.cache_bytes},
      {"memory_bytes", &train.memory_bytes},
      {"poses.camera", &train.poses.camera},
      {"poses.lidar", &train.poses.lidar},
      {"poses.translation_m", &train.poses.translation_m},
      {"poses.rotation_rad", &train.poses.rotation_rad},
  };
  const auto add_rates = [&all](const std::string& set, LearningRates& rates) {
    all.push_back({set + ".rate.mean_m", &rates.mean_m});
    all.push_back({set + ".rate.mean_final_m", &rates.mean_final_m});
    all.push_back({set + ".rate.log_scale", &rates.log_scale});
    all.push_back({set + ".rate.rotation", &rates.rotation});
    all.push_back({set + ".rate.opacity", &rates.opacity});
    all.push_back({set + ".rate.sh", &rates.sh});
    all.push_back({set + ".rate.sh_rest", &rates.sh_rest});
    all.push_back({set + ".rate.final_share", &rates.final_share});
  };
  add_rates("camera", train.camera);
  add_rates("lidar", train.lidar);
  for (Setting& setting : render_settings(train.render)) all.push_back(std::move(setting));
  return all;
}

}  // namespace simuli::cli
