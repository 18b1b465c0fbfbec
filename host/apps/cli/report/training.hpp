#pragma once
// Trainings and evaluations of the commands train, eval and demo: progress and text.
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

/// History of a training at up to kPoints iterations. Each vector has one value per point; NaN: not known yet.
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

/// Outputs of a training besides its scene.
struct TrainOutputs {
  Checkpoints checkpoints;
  bool resume = false;                 // from checkpoints.file, if it exists
  std::filesystem::path event_folder;  // for TensorBoard; empty: none
  LivePage* view = nullptr;            // viewer; null: none
  std::string frames = {};     // frames of each sensor, printed before the first step; empty: not printed
  Ranks* ranks = &one_rank();  // ranks of the training; only the first one prints
};

/// Prepares and runs a training, with progress on stderr. Prints one warning line each for rejected gradients,
/// an early stop and warnings of judge(); throws Error{kNumeric} for failures of judge(). With checkpoints, a
/// signal to any rank stores the state and throws Interrupted in all ranks.
TrainHistory run_training(Training& training,
                          const Device& device,
                          const Globals& globals,
                          const TrainOutputs& outputs = {});

/// Returns Training::result(), with progress as a stage of its own: it renders the training frames and inpaints
/// disocclusions.
[[nodiscard]] SceneFile trained_scene(Training&& training, const Globals& globals);

/// Runs an evaluation with progress. For a scene that was trained by this command, `folder` is its folder,
/// which stores the scores.
[[nodiscard]] EvalReport run_evaluation(Evaluation& evaluation,
                                        const Globals& globals,
                                        const std::filesystem::path& scene = {});

[[nodiscard]] std::vector<ScoreLine> metric_lines(const EvalReport& report);
/// Prints a report to stdout, as a table with units or as JSON with units in the key names. `scene` provides
/// the training record; `support`: if requested.
void print_eval(const EvalReport& report,
                const SceneFile& scene,
                bool json,
                const EvalSupport* support = nullptr);

}  // namespace simuli::cli
