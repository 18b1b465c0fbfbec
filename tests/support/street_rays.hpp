#pragma once
#include <Eigen/Core>
#include <cmath>

namespace simuli::test {

/// Returns a ray from the drive in a direction that depends on its number.
struct StreetRay {
  Eigen::Vector3d origin, direction;
};
inline StreetRay ray_of(int i) {
  const double share = i * 0.6180339887498949, turn = i * 0.7548776662466927, up = i * 0.5698402909980532;
  const auto fraction = [](double x) { return x - std::floor(x); };
  const double azimuth = 6.283185307179586 * fraction(turn), z = 0.9 * fraction(up) - 0.45;
  const double flat = std::sqrt(1.0 - z * z);
  return {{260.0 * fraction(share), 1.5 * std::sin(0.1 * i) - 0.5, 1.9},
          {flat * std::cos(azimuth), flat * std::sin(azimuth), z}};
}

}  // namespace simuli::test
