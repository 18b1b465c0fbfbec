#include "optim/eval/held_out_scores.hpp"

#include <algorithm>
#include <utility>

namespace simuli {

HeldOutScores scores_of(const EvalReport& r) {
  return {.images = r.images,
          .sweeps = r.sweeps,
          .image_width = r.image_width,
          .image_height = r.image_height,
          .psnr_db = r.psnr_db,
          .ssim = r.ssim,
          .distance_median_m = r.lidar.distance_median_m,
          .intensity_rmse = r.lidar.intensity_rmse,
          .raydrop_accuracy = r.lidar.raydrop_accuracy,
          .chamfer_m = r.lidar.chamfer_m};
}

EvalReport score_trained(Evaluation& evaluation,
                         const std::filesystem::path& folder,
                         const Evaluation::Progress& progress) {
  EvalReport report = evaluation.run(progress);
  if (report.frames.kind == FrameKind::kHeldOut) {
    evaluation.keep(scores_of(report));
    rewrite_scene_json(folder, evaluation.scene());
  }
  return report;
}

std::optional<HeldOutScores> write_trained_scene(const std::filesystem::path& folder,
                                                 const Device& device,
                                                 SceneFile scene,
                                                 Log log,
                                                 const RenderOptions& render) {
  write_scene(folder, scene);
  if (!has_held_out(scene)) return {};
  Evaluation evaluation(device, std::move(scene), std::move(log), {.render = render});
  return scores_of(score_trained(evaluation, folder));
}

bool has_held_out(const SceneFile& scene) {
  if (!scene.training) return false;
  const std::vector<SensorUse>& uses = scene.training->sensors;
  return std::any_of(uses.begin(), uses.end(), [](const SensorUse& use) { return use.held_out > 0; });
}

}  // namespace simuli
