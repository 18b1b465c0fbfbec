#include "optim/train/training_options.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host/base/error.hpp"

namespace simuli {

TrainOptions checked(const TrainOptions& o) {
  const auto need = [](bool holds, const char* field, double found, const char* allowed) {
    if (holds) return;
    throw Error(ErrorKind::kUsage, fmt::format("train: {}: found {}, allowed {}", field, found, allowed));
  };
  need(o.iterations >= 0, "iterations", o.iterations, "0 or more");
  need(o.lidar_every >= 1, "lidar_every", o.lidar_every, "1 or more");
  need(o.max_seconds >= 0.0, "max_seconds", o.max_seconds, "0 (no limit) or more");
  if (o.render.precision != Precision::kFloat) {
    throw Error(ErrorKind::kUsage, "train: precision: found double, allowed float");
  }
  if (!has_gradients(o.render)) {
    throw Error(
        ErrorKind::kUsage,
        "train: render: found an order, sh_direction, sh_degree or sh_storage without gradients, allowed "
        "range, particle, 3 and full");
  }
  for (const LearningRates* r : {&o.camera, &o.lidar}) {
    need(r->mean_m > 0.0 && r->mean_final_m > 0.0 && std::isfinite(r->mean_m + r->mean_final_m),
         "mean rate",
         std::min(r->mean_m, r->mean_final_m),
         "finite and above 0");
    need(r->final_share > 0.0 && r->final_share <= 1.0, "final_share", r->final_share, "above 0, at most 1");
    for (const double rate : {r->log_scale, r->rotation, r->opacity, r->sh, r->sh_rest}) {
      need(rate >= 0.0 && std::isfinite(rate), "learning rate", rate, "finite, 0 or more");
    }
  }
  const LookOptions& l = o.look;
  need(l.final_share > 0.0 && l.final_share <= 1.0, "look.final_share", l.final_share, "above 0, at most 1");
  for (const double rate : {l.environment_rate, l.grid_rate}) {
    need(rate >= 0.0 && std::isfinite(rate), "learning rate", rate, "finite, 0 or more");
  }
  for (const double weight : {o.weights.distance,
                              o.weights.intensity,
                              o.weights.drop,
                              o.image.absolute,
                              o.image.squared,
                              o.image.dissimilarity,
                              l.environment_variation,
                              l.grid_variation,
                              l.grid_drift,
                              o.camera_particles.scale,
                              o.camera_particles.opacity,
                              o.camera_particles.entropy,
                              o.lidar_particles.scale,
                              o.lidar_particles.opacity,
                              o.lidar_particles.entropy}) {
    need(weight >= 0.0 && std::isfinite(weight), "loss weight", weight, "finite, 0 or more");
  }
  const AnchorOptions& a = o.anchor;
  need(a.weight >= 0.0 && std::isfinite(a.weight), "anchor.weight", a.weight, "finite, 0 or more");
  need(a.neighbours >= 1 && a.neighbours <= 256, "anchor.neighbours", a.neighbours, "1 to 256");
  need(a.every >= 1, "anchor.every", a.every, "1 or more");
  need(a.choose_every >= 1, "anchor.choose_every", a.choose_every, "1 or more");
  need(a.reach_m > 0.0, "anchor.reach_m", a.reach_m, "above 0");
  const DensifyOptions& d = o.densify;
  need(d.every >= 0, "densify.every", d.every, "0 (never) or more");
  need(d.first >= 1, "densify.first", d.first, "1 or more");
  need(d.last_share >= 0.0 && d.last_share <= 1.0, "densify.last_share", d.last_share, "0 to 1");
  need(d.growth >= 0.0 && d.growth <= 1.0, "densify.growth", d.growth, "0 to 1");
  need(d.noise >= 0.0 && std::isfinite(d.noise), "densify.noise", d.noise, "finite, 0 or more");
  for (const double rate : {o.poses.translation_m, o.poses.rotation_rad}) {
    need(rate >= 0.0 && std::isfinite(rate), "poses rate", rate, "finite, 0 or more");
  }
  for (const double rate : {o.actor_poses.shift_m, o.actor_poses.turn_rad}) {
    need(rate >= 0.0 && std::isfinite(rate), "actor pose rate", rate, "finite, 0 or more");
  }
  need(o.actor_poses.final_share > 0.0 && o.actor_poses.final_share <= 1.0,
       "actor pose final_share",
       o.actor_poses.final_share,
       "above 0, at most 1");
  need(o.actor_margin_m >= 0.0 && std::isfinite(o.actor_margin_m),
       "actor_margin_m",
       o.actor_margin_m,
       "finite, 0 or more");
  return o;
}

TrainingOptions checked(const TrainingOptions& options) {
  validate(options.frames);
  static_cast<void>(checked(options.train));
  return options;
}

}  // namespace simuli
