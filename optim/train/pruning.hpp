#pragma once
// Pruning of the LiDAR set by what its sweeps need (METHOD section 11).
#include "optim/train/trainer_state.hpp"

namespace simuli {

/// Whether it is its turn before the iteration that is next.
[[nodiscard]] bool is_prune_turn(const TrainerState& state);
/// Takes out what no training sweep needs of the LiDAR set, and corrects the rows' ranges by what they state
/// beside what the set shows.
void prune(TrainerState& state);

}  // namespace simuli
