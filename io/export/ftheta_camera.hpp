#pragma once
// F-theta cameras in the numbers that NVIDIA's programs exchange: set_ftheta() the other way.
#include <array>

#include "host/core/sensors/camera.hpp"

namespace simuli {

/// Polynomials have degrees 0 to 5, degree 0 being 0, in pixels down the picture and radians; what is wider
/// or narrower across the picture is in the linear part [[c d] [e 1]]. The principal point is counted from
/// the centre of the first pixel.
struct FthetaCamera {
  bool is_inverse = false;                  // which polynomial the camera is made of: pixels to angle
  std::array<double, 6> pixels_to_angle{};  // the other one is fitted to it, within max_angle_rad
  std::array<double, 6> angle_to_pixels{};
  std::array<double, 3> linear_cde{};
  double max_angle_rad = 0.0;
  std::array<double, 2> principal_point{};
};

/// Of a camera with such a lens, kFtheta or kFthetaInverse.
[[nodiscard]] FthetaCamera ftheta_of(const Camera& camera);

}  // namespace simuli
