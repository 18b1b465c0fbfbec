#pragma once
// Training and evaluation with what the commands train, eval and demo share of it: progress and text.
#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/base/commands.hpp"
#include "io/scene/scene_folder.hpp"
#include "optim/eval/evaluate.hpp"
#include "optim/init/initialize.hpp"
#include "optim/train/trainer.hpp"

namespace simuli::cli {

class ViewSession;

/// How a training went, at most kPoints times of it. One value each per point; NaN: not known yet.
struct TrainHistory {
  static constexpr int kPoints = 400;
  std::vector<double> iteration;
  std::vector<double> psnr_db;
  std::vector<double> distance_m;
  std::vector<double> drop_accuracy;
  std::vector<double> camera_particles;
  std::vector<double> lidar_particles;
  std::vector<double> device_bytes;
};

struct TrainedScene {
  SceneFile file;  // with the log's sensors and trajectory
  InitReport init;
  TrainReport training;
  TrainHistory history;
};
/// Where a training is stored meanwhile, and whether it goes on from there.
struct Checkpoints {
  std::filesystem::path file;
  int every = 0;        // iterations; 0: never
  bool resume = false;  // from the file, if there is one
};
/// What a training does beside: for all who look on.
struct TrainOutputs {
  Checkpoints checkpoints;
  std::filesystem::path event_folder;  // TensorBoard's; empty: none
  ViewSession* view = nullptr;         // who shows it; may be nobody
};

/// Initialises a scene from the log and trains it, with progress on stderr. A warning line tells of
/// rejected gradients and of an early stop.
[[nodiscard]] TrainedScene train_scene(const Device& device,
                                       const Log& log,
                                       const InitOptions& init,
                                       const TrainOptions& options,
                                       const Globals& globals,
                                       const TrainOutputs& outputs = {});

/// The same for evaluate().
[[nodiscard]] EvalReport evaluate_scene(const Device& device,
                                        const Log& log,
                                        const Scene& scene,
                                        const EvalOptions& options,
                                        const Globals& globals);
/// A metric as people read it.
struct MetricLine {
  std::string name;
  std::string value;
  std::string unit;
};
[[nodiscard]] std::vector<MetricLine> metric_lines(const EvalReport& report);
/// On stdout, as a table with units or as JSON with units in the key names.
void print_eval(const EvalReport& report, bool json);

}  // namespace simuli::cli
