#pragma once
// Training and evaluation with what the commands train, eval and demo share of it: progress and text.
#include <filesystem>

#include "host/cli/commands.hpp"
#include "io/scene_folder.hpp"
#include "optim/evaluate.hpp"
#include "optim/initialize.hpp"
#include "optim/trainer.hpp"

namespace simuli::cli {

struct TrainedScene {
  SceneFile file;  // with the log's sensors and trajectory
  InitReport init;
  TrainReport training;
};
/// Where a training is stored meanwhile, and whether it goes on from there.
struct Checkpoints {
  std::filesystem::path file;
  int every = 0;        // iterations; 0: never
  bool resume = false;  // from the file, if there is one
};

/// Initialises a scene from the log and trains it, with progress on stderr. A warning line tells of
/// rejected gradients and of an early stop.
[[nodiscard]] TrainedScene train_scene(const Device& device,
                                       const Log& log,
                                       const InitOptions& init,
                                       const TrainOptions& options,
                                       const Globals& globals,
                                       const Checkpoints& checkpoints = {});

/// The same for evaluate().
[[nodiscard]] EvalReport evaluate_scene(const Device& device,
                                        const Log& log,
                                        const Scene& scene,
                                        const EvalOptions& options,
                                        const Globals& globals);
/// On stdout, as a table with units or as JSON with units in the key names.
void print_eval(const EvalReport& report, bool json);

}  // namespace simuli::cli
