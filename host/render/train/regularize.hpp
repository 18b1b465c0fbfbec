#pragma once
#include "host/render/frame/particle_buffers.hpp"
#include "host/runtime/kernel.hpp"

namespace simuli {

/// Weights of what a set is asked beside its pictures (METHOD section 10), of one particle each.
struct RegularizeScale {
  double scale = 0.0;    // of the sum of its three standard deviations, m
  double opacity = 0.0;  // of its opacity
  double entropy = 0.0;  // of its opacity's entropy, nats: pulls to 0 and 1
  [[nodiscard]] bool is_zero() const { return scale == 0.0 && opacity == 0.0 && entropy == 0.0; }
};

class RegularizeStage {
 public:
  RegularizeStage(const Device& device, Precision precision);
  /// Adds to param_grads[param_rows][stride], as backward left them.
  void run(const ParticleBuffers& particles, const RegularizeScale& scale, RealBuffer& param_grads);

 private:
  int lanes_;
  Kernel regularize_;
};

}  // namespace simuli
