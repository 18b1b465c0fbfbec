#pragma once
// Ranks within one process: a thread each.
#include <cstddef>
#include <functional>

#include "optim/train/ranks/ranks.hpp"

namespace simuli {

/// Runs `work` once for each of `count` ranks, side by side, rank 0 on the calling thread; returns when all
/// are done. When one leaves with an exception the others do so at their next call, and what is thrown here
/// is the first one's.
void run_rank_threads(std::size_t count, const std::function<void(Ranks&)>& work);

}  // namespace simuli
