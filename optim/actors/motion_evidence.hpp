#pragma once
// Classifies returns as moving or static by the sweeps shortly before and after.
#include <cstdint>
#include <vector>

#include "optim/actors/sweep_series.hpp"

namespace simuli {

enum class Motion : std::uint8_t {
  kUnknown,  // too few votes
  kStands,  // present before and afterwards
  kMoves  // other sweeps see through its position
};

/// Classifies [sweeps][points] by up to 8 sweeps on either side, within about 2.5 s at 10 Hz. A return moves if
/// on one side at least three sweeps see through its position and hardly any hits something there, or all do
/// from some sweep on with increasing time distance: it arrived, or left.
[[nodiscard]] std::vector<std::vector<Motion>> motion_evidence(const SweepSeries& series);

}  // namespace simuli
