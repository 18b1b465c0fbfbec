#include "optim/trained_set.hpp"

namespace simuli {

TrainedSet::TrainedSet(const Device& device, const GaussianSet& set)
    : particles(device, set, Precision::kFloat),
      grads(device, "gradients", Precision::kFloat, particles.params.count()),
      adam(device, particles) {
  grads.fill(0.0);  // padding behind the last particle gets no gradient from any kernel
}

}  // namespace simuli
