#pragma once
// Ranks within one process, one thread each.
#include <cstddef>
#include <functional>

#include "optim/train/ranks/ranks.hpp"

namespace simuli {

/// Runs `work` concurrently for each of `count` ranks, rank 0 on the calling thread, and returns when all have
/// finished. When one throws, the others fail at their next call, and this function rethrows the first
/// exception.
void run_rank_threads(std::size_t count, const std::function<void(Ranks&)>& work);

}  // namespace simuli
