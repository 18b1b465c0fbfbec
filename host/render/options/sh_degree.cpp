#include "host/render/options/sh_degree.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace simuli {

double dropped_sh(const GaussianSet& set, int degree) {
  double energy = 0.0, weight = 0.0;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const double opacity = 1.0 / (1.0 + std::exp(-static_cast<double>(set.opacity_logit()(i))));
    double sum = 0.0;
    for (int k = sh_coefficients(degree); k < sh_coefficients(set.sh_degree); ++k) {
      for (int c = 0; c < 3; ++c) {
        const auto value = static_cast<double>(set.sh(k)(i, c));
        sum += value * value;
      }
    }
    // Particles that are no numbers are never seen.
    if (!std::isfinite(opacity * sum)) continue;
    energy += opacity * sum;
    weight += opacity;
  }
  constexpr double kChannels = 3.0;
  return weight > 0.0 ? std::sqrt(energy / (weight * kChannels * 4.0 * std::numbers::pi)) : 0.0;
}

int sufficient_sh_degree(const GaussianSet& set, double error) {
  int degree = 0;
  while (degree < set.sh_degree && dropped_sh(set, degree) > error) ++degree;
  return degree;
}

int kept_sh_degree(const GaussianSet& set, ShDegree asked, double error) {
  if (asked == ShDegree::kAuto) return sufficient_sh_degree(set, error);
  return std::min(set.sh_degree, static_cast<int>(asked));
}

}  // namespace simuli
