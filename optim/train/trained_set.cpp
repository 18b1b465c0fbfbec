#include "optim/train/trained_set.hpp"

namespace simuli {

TrainedSet::TrainedSet(const Device& device, const GaussianSet& set, const PoseRates& pose_rates)
    : particles(device, set, Precision::kFloat),
      grads(device, "gradients", Precision::kFloat, particles.params.count()),
      error(device, "reconstruction errors", Precision::kFloat, particles.count),
      adam(device, particles),
      poses(pose_rates) {
  grads.fill(0.0);
  error.fill(0.0);
}

void TrainedSet::fit_gradients() {
  if (grads.count() == particles.params.count()) return;
  grads.reserve(particles.params.count());
  grads.fill(0.0);  // padding behind the last particle gets no gradient from any kernel
}

}  // namespace simuli
