// C API of training and evaluation.
#include <utility>

#include "host/apps/api/c_handles.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/eval/eval_options.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/eval/held_out_scores.hpp"
#include "optim/train/training.hpp"

using namespace simuli;
using namespace simuli::capi;

extern "C" {

simuli_status simuli_train(const simuli_device* device,
                           const char* log,
                           const char* scene,
                           const simuli_options* options,
                           simuli_progress progress,
                           void* user,
                           simuli_training* result) {
  return guarded([&] {
    const std::string folder = &need(scene, "scene");
    const TrainingOptions checked_options =
        // fails before any file is read
        training_options(capi::quality_of(options), capi::settings_of(options));
    const SceneOutput output(folder);
    const Device& on = need(device, "device").device;
    const Log recorded = read_log(&need(log, "log"));
    Training training(on, recorded, checked_options);
    const TrainReport report = training
                                   .run([&](const TrainStatus& status) {
                                     if (progress == nullptr) return;
                                     if (progress(status.iteration, status.psnr_db, user) == 0) return;
                                     throw Error(ErrorKind::kUsage, "training: ended by its observer");
                                   })
                                   .train;
    SceneFile made = std::move(training).result();
    const auto camera_particles = static_cast<std::size_t>(made.scene.camera.size());
    const auto lidar_particles = static_cast<std::size_t>(made.scene.lidar.size());
    write_trained_scene(folder, on, std::move(made), recorded, checked_options.train.render);
    if (result == nullptr) return;
    *result = {report.last.iteration,
               report.last.psnr_db,
               report.last.distance_m,
               camera_particles,
               lidar_particles,
               report.seconds};
  });
}

simuli_status simuli_evaluate(const simuli_device* device,
                              const char* scene,
                              const char* log,
                              const simuli_options* options,
                              simuli_evaluation* result) {
  return guarded([&] {
    simuli_evaluation& out = need(result, "result");
    const EvalOptions checked_options = eval_options(capi::quality_of(options), capi::settings_of(options));
    Evaluation evaluation(need(device, "device").device,
                          read_scene(&need(scene, "scene")),
                          read_log(&need(log, "log")),
                          checked_options);
    const EvalReport report = evaluation.run();
    out = {report.images,
           report.sweeps,
           report.frames.kind == FrameKind::kHeldOut ? 1 : 0,
           report.psnr_db,
           report.ssim,
           report.lidar.distance_median_m,
           report.lidar.intensity_rmse,
           report.lidar.raydrop_accuracy,
           report.lidar.chamfer_m,
           report.lidar.raydrop_trivial,
           report.lidar.drop_recall,
           report.lidar.drop_precision};
  });
}

}  // extern "C"
