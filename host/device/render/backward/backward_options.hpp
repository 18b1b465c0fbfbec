#pragma once
#include <cstddef>

namespace simuli {

/// Weights of a grid's own losses: of the squared differences of neighbours and to the identity.
struct ColorGridScale {
  double variation = 0.0;
  double drift = 0.0;
};

/// What a backward pass may give beside the gradients of particles, and what it may take.
struct BackwardExtras {
  bool errors = false;  // ray_error -> pair_error, weighted by blending
  /// Where rays have orders of their own, what they blend is kept for tiles of together at most so many
  /// pairs at a time, at least for one tile: 2 KB each in float. Gradients are the same bits.
  std::size_t replayed = std::size_t{1} << 17U;
};

}  // namespace simuli
