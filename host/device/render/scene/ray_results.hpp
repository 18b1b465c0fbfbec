#pragma once
#include <cstddef>
#include <vector>

namespace simuli {

/// Results by ray, in ray order (pixels or beams row-major).
struct RayResults {
  std::size_t rays = 0;
  std::vector<float> feature[3];     // [rays] colour, or intensity, hit logit, drop logit
  std::vector<float> transmittance;  // [rays]
  std::vector<float> distance;       // [rays] sum of w tau, m; divide by 1 - transmittance for the mean
  std::vector<float> median;         // [rays] m, 0 where transmittance stays above 1/2; may be empty

  std::vector<float> drop_logit;  // [rays] of LiDARs: ln(p / (1 - p)) of drop_probability(); else empty

  /// Probability that a LiDAR ray does not return.
  [[nodiscard]] float drop_probability(std::size_t ray) const;
  /// Expected distance in m; 0 for a ray without any hit.
  [[nodiscard]] float expected_distance(std::size_t ray) const;
};

}  // namespace simuli
