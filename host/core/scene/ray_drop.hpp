#pragma once
// Ray-drop functions of LiDARs (METHOD section 7), trained together with the particles.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace simuli {

/// The ray-drop function of a sensor: ln(p / (1 - p)) of the probability p that a ray does not return, from the
/// ray's blended outputs (cl/math/ray_drop.h).
struct RayDrop {
  static constexpr std::size_t kParameters = 53;  // number of reals of DropConstants (cl/shared/sensor_constants.h)
  using Parameters = std::array<double, kParameters>;

  std::string lidar;  // its name
  Parameters parameters{};

  /// p is the softmax of the blended hit and drop logits, independent of other outputs.
  [[nodiscard]] static Parameters of_logits();
  /// The same function, as start of a training: hidden units have different inputs and zero output weights.
  [[nodiscard]] static Parameters start();

  bool operator==(const RayDrop&) const = default;
};

/// Returns the function of the LiDAR of that name, else of the first one (surfaces that return nothing to one
/// sensor return nothing to another), else that of the logits.
[[nodiscard]] RayDrop::Parameters ray_drop_of(const std::vector<RayDrop>& all, const std::string& lidar);

}  // namespace simuli
