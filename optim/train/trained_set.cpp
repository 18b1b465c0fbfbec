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

void TrainedSet::add_state(StateList& list, const std::string& name) {
  list.add(name + "/count", particles.count);
  list.add(name + "/stride", particles.stride);
  list.add(name + "/parameters", particles.params);
  list.add(name + "/actors", particles.actor_of);
  list.add(name + "/first_moment", adam.first_moment());
  list.add(name + "/second_moment", adam.second_moment());
  list.add(name + "/steps", adam.iteration());
  list.add(name + "/rejections", adam.rejections());
  list.add(name + "/errors", error);
}

}  // namespace simuli
