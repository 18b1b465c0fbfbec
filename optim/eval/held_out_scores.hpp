#pragma once
// Scores of held-out frames, stored with the scene.
#include <filesystem>
#include <optional>

#include "optim/eval/evaluation.hpp"

namespace simuli {

/// Scores of the compared frames, of any kind.
[[nodiscard]] HeldOutScores scores_of(const EvalReport& report);

/// Evaluates a trained scene that was written to `folder`. Scores of held-out frames are stored in that
/// folder's scene.json (TrainingRecord::held_out). Throws as Evaluation::run().
EvalReport score_trained(Evaluation& evaluation,
                         const std::filesystem::path& folder,
                         const Evaluation::Progress& progress = {});

/// Whether the scene's training held out frames; a log of few frames may have none.
[[nodiscard]] bool has_held_out(const SceneFile& scene);

/// Final step of every training: writes the scene to its folder, then evaluates held-out frames, if any, with
/// the options `render` of the training. `log` as it was read. The scene is written even if the evaluation
/// fails.
std::optional<HeldOutScores> write_trained_scene(const std::filesystem::path& folder,
                                                 const Device& device,
                                                 SceneFile scene,
                                                 Log log,
                                                 const RenderOptions& render);

}  // namespace simuli
