#pragma once
// Particles for tests of files.
#include <random>

#include "host/core/scene/gaussians.hpp"

namespace simuli::test {

inline GaussianSet some_set(int degree, Eigen::Index count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  GaussianSet set(SetKind::kCamera, degree, count);
  for (Eigen::Index v = 0; v < count; ++v) {
    for (Eigen::Index c = 0; c < set.params.cols(); ++c) set.params(v, c) = 0.9F * unit(random);
    set.mean().row(v) *= 100.0F;
    set.log_scale().row(v).array() -= 3.0F;
    set.opacity_logit()(v) *= 4.0F;
  }
  return set;
}

}  // namespace simuli::test
