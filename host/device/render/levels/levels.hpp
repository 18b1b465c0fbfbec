#pragma once
// Level of detail: what few pixels show is drawn as few particles (METHOD section 4).
#include <vector>

#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// Particles of a set, in its order, and behind them such that stand for several. With k = rays per rad of a
/// sensor over the footprint asked for (RenderOptions::detail) a particle is drawn from the distance k from_m
/// on and up to k until_m, and comes and goes over the eighth beyond each.
struct DetailLevels {
  GaussianSet set;
  std::vector<float> from_m;   // [N] 0 for particles of the set itself
  std::vector<float> until_m;  // [N] kNeverMerged for those that no other stands for
};
inline constexpr float kNeverMerged = 1e30F;
/// A particle is all there, or all gone, at this many times the distance where it begins to be.
inline constexpr float kDetailFade = 1.125F;

/// Particles of one owner in one cell of an octree, none larger than half of it, become one: with their mean,
/// covariance and features, weighed by opacity and size, and with the opacity of all of them, each scattered
/// over its size. So in cells of 1/16 m, then of twice the side, up to 64 m. One stands for others from where
/// its standard deviation along its longest axis is less than the footprint, so at any distance each particle
/// of the set is drawn itself or has one that stands for it. What is not a number is never merged.
[[nodiscard]] DetailLevels detail_levels(const GaussianSet& set);

}  // namespace simuli
