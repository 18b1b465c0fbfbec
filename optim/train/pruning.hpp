#pragma once
// Prunes the LiDAR set by its contribution to the training sweeps (METHOD section 11).
#include "optim/train/trainer_state.hpp"

namespace simuli {

/// Whether pruning is due before the next iteration.
[[nodiscard]] bool is_prune_turn(const TrainerState& state);
/// Removes LiDAR particles that contribute to no training sweep, and updates the rows' range biases by the mean
/// difference between recorded and rendered ranges.
void prune(TrainerState& state);

}  // namespace simuli
