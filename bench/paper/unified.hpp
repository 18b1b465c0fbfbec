#pragma once
#include "bench/paper/fit.hpp"

namespace simuli::bench {

/// What table 5 compares factorised sets with: one set of particles that both sensors see, each with features
/// of its own, trained on pictures and sweeps together (loss weights of METHOD section 10) with the distances
/// weighted by `distance_weight`. Geometry and colours start as the camera set of `start`. The result holds
/// the same geometry twice, once with each sensor's features.
[[nodiscard]] Scene fit_unified(const Device& device,
                                const Log& log,
                                Scene start,
                                const TrainingOptions& options,
                                double distance_weight);

}  // namespace simuli::bench
