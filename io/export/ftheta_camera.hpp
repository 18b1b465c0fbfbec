#pragma once
// F-theta cameras in the parameters of NVIDIA's programs: the inverse of set_ftheta().
#include <array>

#include "host/core/sensors/camera.hpp"

namespace simuli {

/// Polynomials have degrees 0 to 5 with degree 0 equal to 0, in vertical pixels and radians; the horizontal
/// scale is in the linear part [[c d] [e 1]]. The principal point is relative to the centre of the first pixel.
struct FthetaCamera {
  bool is_inverse = false;  // which polynomial defines the camera: true for pixels to angle
  // the other polynomial is fitted to the defining one within max_angle_rad
  std::array<double, 6> pixels_to_angle{};
  std::array<double, 6> angle_to_pixels{};
  std::array<double, 3> linear_cde{};
  double max_angle_rad = 0.0;
  std::array<double, 2> principal_point{};
};

/// Returns the parameters of a camera with a lens kFtheta or kFthetaInverse.
[[nodiscard]] FthetaCamera ftheta_of(const Camera& camera);

}  // namespace simuli
