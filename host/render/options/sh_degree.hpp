#pragma once
// How many bands of spherical harmonics a set needs.
#include "host/render/options/options.hpp"
#include "host/scene/gaussians.hpp"

namespace simuli {

/// RMS over directions, channels and particles of what the bands above `degree` add to a feature (of 1; of a
/// LiDAR's logits as they are), particles weighted by their opacity; 0 for an empty set. By Parseval: the sum
/// of the squared coefficients over 4 pi.
[[nodiscard]] double dropped_sh(const GaussianSet& set, int degree);

/// The lowest degree of which dropped_sh() is at most `error`.
[[nodiscard]] int sufficient_sh_degree(const GaussianSet& set, double error);

/// The degree with which a set is rendered: never more than it has.
[[nodiscard]] int kept_sh_degree(const GaussianSet& set, ShDegree asked, double error);

}  // namespace simuli
