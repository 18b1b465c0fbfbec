#pragma once
// What makes a LiDAR's rays return nothing (METHOD section 7), learned with the particles.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace simuli {

/// The drop function of a sensor: ln(p / (1 - p)) of the probability p that a ray doesn't return, by what
/// blending has left of the ray (cl/math/ray_drop.h).
struct RayDrop {
  static constexpr std::size_t kParameters = 53;  // the reals of DropConstants (cl/shared/sensor_constants.h)
  using Parameters = std::array<double, kParameters>;

  std::string lidar;  // its name
  Parameters parameters{};

  /// p is the softmax of the blended hit and drop logits, whatever else a ray has met.
  [[nodiscard]] static Parameters of_logits();
  /// The same to begin a training with: its hidden values are of differing sums, and weigh nothing yet.
  [[nodiscard]] static Parameters start();

  bool operator==(const RayDrop&) const = default;
};

/// The function of the LiDAR of that name, else of the first one (a surface that one sensor gets no light
/// back from gives another none, either), else of the logits alone.
[[nodiscard]] RayDrop::Parameters ray_drop_of(const std::vector<RayDrop>& all, const std::string& lidar);

}  // namespace simuli
