#pragma once
#include <cstddef>

namespace simuli {

/// Weights of a colour grid's regularisation: squared differences between neighbours and to the identity.
struct ColorGridScale {
  double variation = 0.0;
  double drift = 0.0;
};

/// Optional outputs of a backward pass, and its memory limit.
struct BackwardExtras {
  bool errors = false;  // ray_error -> pair_error, weighted by blending
  /// For rays in their own order, replay data are stored for tiles with up to this many pairs in total at a
  /// time, but at least one tile: 2 KB per pair in float. Gradients have the same bits for any value.
  std::size_t replayed = std::size_t{1} << 17U;
};

}  // namespace simuli
