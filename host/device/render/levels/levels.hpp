#pragma once
// Level of detail: small distant groups of particles are rendered as few particles (METHOD section 4).
#include <vector>

#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// Particles of a set in order, followed by merged particles. With k = the sensor's rays per rad divided by the
/// requested footprint (RenderOptions::detail), a particle is rendered at distances from k from_m to k until_m,
/// and fades over the eighth beyond each.
struct DetailLevels {
  GaussianSet set;
  std::vector<float> from_m;  // [N] 0 for particles of the set
  std::vector<float> until_m;  // [N] kNeverMerged for particles without a merged representative
};
inline constexpr float kNeverMerged = 1e30F;
/// A particle fades in or out up to this multiple of its limit distance.
inline constexpr float kDetailFade = 1.125F;

/// Merges particles of one owner in one cell of an octree, none larger than half the cell: the merged particle
/// has their mean, covariance and features, weighted by opacity and size, and their total opacity, each spread
/// over its size. Cells have sides of 1/16 m, doubled up to 64 m. A merged particle is rendered where its
/// standard deviation along the longest axis is smaller than the footprint, so that at any distance each
/// particle of the set is rendered itself or is represented by one merged particle. Particles with non-finite
/// parameters are never merged.
[[nodiscard]] DetailLevels detail_levels(const GaussianSet& set);

}  // namespace simuli
