// Implements the drop function of METHOD section 7.
#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/support/reference.hpp"

namespace simuli::reference {

double drop_logit(const RayDrop::Parameters& parameters, const RayResult& ray) {
  const double opacity = 1.0 - ray.transmittance;
  const double mean_m = opacity > 1e-9 ? ray.distance / opacity : 0.0;
  const std::vector<double> inputs{ray.feature[2] - ray.feature[1],
                                   10.0 * ray.transmittance,
                                   10.0 * ray.feature[0],
                                   10.0 * opacity * mean_m / (mean_m + 20.0)};
  constexpr std::size_t kHidden = 8;
  const std::size_t n = inputs.size();
  const double* const skip = parameters.data();
  const double* const hidden = skip + n + 1;
  const double* const out = hidden + kHidden * (n + 1);
  double logit = skip[n];
  for (std::size_t j = 0; j < n; ++j) logit += skip[j] * inputs[j];
  for (std::size_t k = 0; k < kHidden; ++k) {
    double sum = hidden[k * (n + 1) + n];
    for (std::size_t j = 0; j < n; ++j) sum += hidden[k * (n + 1) + j] * inputs[j];
    logit += out[k] * sum / (1.0 + std::abs(sum));
  }
  return logit;
}

}  // namespace simuli::reference
