#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace simuli {

struct RayGrid;

/// What every ray saw, in ray order (pixels or beams row-major).
struct RayResults {
  std::size_t rays = 0;
  std::vector<float> feature[3];     // [rays] colour, or intensity, hit logit, drop logit
  std::vector<float> transmittance;  // [rays]
  std::vector<float> distance;       // [rays] sum of w tau, m; divide by 1 - transmittance for the mean
  std::vector<float> median;         // [rays] m, 0 where transmittance stays above 1/2; may be empty

  /// softmax(hit, drop)[drop] of a LiDAR ray.
  [[nodiscard]] float drop_probability(std::size_t ray) const;
  /// Expected distance in m; 0 where nothing at all was met.
  [[nodiscard]] float expected_distance(std::size_t ray) const;
};

/// From slot order. outputs: [SIM_OUTPUTS][slots]; picture: [3][slots], shown instead of the outputs'
/// features where it isn't empty. Pixels without a ray show `background`.
[[nodiscard]] RayResults results_of(const RayGrid& grid,
                                    std::span<const float> outputs,
                                    std::span<const float> picture,
                                    const std::array<float, 3>& background,
                                    bool has_median);

}  // namespace simuli
