#pragma once
// Which returns were on something that moved, as the sweeps shortly before and after tell.
#include <cstdint>
#include <vector>

#include "optim/actors/sweep_series.hpp"

namespace simuli {

enum class Motion : std::uint8_t {
  kUnknown,  // too few sweeps tell
  kStands,   // was there before and afterwards
  kMoves     // other sweeps look through where it was
};

/// [sweeps][points]: each return, by up to 8 sweeps on either side within about 2.5 s at 10 Hz. It moves
/// when on one side three sweeps and more look through its place and hardly any finds something there, or
/// all do from some sweep on, going away in time: it came, or left.
[[nodiscard]] std::vector<std::vector<Motion>> motion_evidence(const SweepSeries& series);

}  // namespace simuli
