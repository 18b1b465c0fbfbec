#pragma once
#include "host/render/stages.hpp"

namespace simuli {

/// A particle set in training: parameters, their gradients, and the optimiser's state.
struct TrainedSet {
  TrainedSet(const Device& device, const GaussianSet& set);
  ParticleBuffers particles;
  RealBuffer grads;  // [param_rows][stride]
  AdamStage adam;
};

}  // namespace simuli
