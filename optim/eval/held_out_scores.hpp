#pragma once
// What frames that a training held out say of its scene, kept with the scene.
#include <filesystem>
#include <optional>

#include "optim/eval/evaluation.hpp"

namespace simuli {

/// Of frames that are compared, whatever kind they are.
[[nodiscard]] HeldOutScores scores_of(const EvalReport& report);

/// Runs the evaluation of a trained scene that was written to `folder`. Where it is of held-out frames, their
/// scores go into that folder's scene.json (TrainingRecord::held_out). Errors as of Evaluation::run().
EvalReport score_trained(Evaluation& evaluation,
                         const std::filesystem::path& folder,
                         const Evaluation::Progress& progress = {});

/// Whether the scene's training held frames out; of a log of few frames it may have none to hold out.
[[nodiscard]] bool has_held_out(const SceneFile& scene);

/// What every training ends with: the scene in its folder, and then the scores of what was held out, if any
/// was, for which `render` is how it was trained. `log` as it was read. The scene is there whatever becomes of
/// its scores.
std::optional<HeldOutScores> write_trained_scene(const std::filesystem::path& folder,
                                                 const Device& device,
                                                 SceneFile scene,
                                                 Log log,
                                                 const RenderOptions& render);

}  // namespace simuli
