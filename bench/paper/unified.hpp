#pragma once
#include "bench/paper/fit.hpp"

namespace simuli::bench {

/// Trains the baseline of table 5: one set of particles for both sensors with separate features, trained on
/// pictures and sweeps together (loss weights of METHOD section 10) with distances weighted by
/// `distance_weight`. Geometry and colours are initialised from the camera set of `start`. The result
/// contains the geometry twice, once with the features of each sensor.
[[nodiscard]] Scene fit_unified(const Device& device,
                                const Log& log,
                                Scene start,
                                const TrainingOptions& options,
                                double distance_weight);

}  // namespace simuli::bench
