#pragma once
// Trainings and evaluations as the commands train, eval and demo show them: progress and text.
#include <filesystem>
#include <string>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/provenance.hpp"
#include "host/apps/cli/report/eval_support.hpp"
#include "optim/eval/evaluation.hpp"
#include "optim/train/training.hpp"

namespace simuli::cli {

class LivePage;

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

/// What a training does beside: for all who look on.
struct TrainOutputs {
  Checkpoints checkpoints;
  bool resume = false;                 // from checkpoints.file, if it is there
  std::filesystem::path event_folder;  // TensorBoard's; empty: none
  LivePage* view = nullptr;            // who shows it; may be nobody
  std::string frames = {};             // of each sensor, told before the first step; empty: not told
  Ranks* ranks = &one_rank();          // the training's; only the first one shows and warns
};

/// Prepares and runs a training, with progress on stderr. A warning line tells of rejected
/// gradients, of an early stop and of what judge() says; Error{kNumeric} for what it calls a failure. With
/// checkpoints a signal to any rank leaves it as Interrupted in all of them, its state stored.
TrainHistory run_training(Training& training,
                          const Device& device,
                          const Globals& globals,
                          const TrainOutputs& outputs = {});

/// Training::result(), which renders the training frames and fills what was hidden, as a stage of its own.
[[nodiscard]] SceneFile trained_scene(Training&& training, const Globals& globals);

/// The same for an evaluation; of a scene that was trained just now with the folder it is in, which keeps its
/// scores.
[[nodiscard]] EvalReport run_evaluation(Evaluation& evaluation,
                                        const Globals& globals,
                                        const std::filesystem::path& scene = {});

[[nodiscard]] std::vector<ScoreLine> metric_lines(const EvalReport& report);
/// On stdout, as a table with units or as JSON with units in the key names; `scene` says how it was made;
/// `support`: where it was asked for.
void print_eval(const EvalReport& report,
                const SceneFile& scene,
                bool json,
                const EvalSupport* support = nullptr);

}  // namespace simuli::cli
