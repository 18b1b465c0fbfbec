#pragma once

namespace simuli {

/// Weights of a grid's own losses: of the squared differences of neighbours and to the identity.
struct ColorGridScale {
  double variation = 0.0;
  double drift = 0.0;
};

/// What a backward pass may give beside the gradients of particles.
struct BackwardExtras {
  bool errors = false;         // ray_error -> instance_error, weighted by blending
  bool ray_gradients = false;  // dL/d(direction), and with origins dL/d(origin), of every ray -> ray_grads
};

}  // namespace simuli
