#pragma once
// Typical windshields in front of cameras: deflections of fractions of a degree, larger towards the edge.
#include "host/core/sensors/lens.hpp"

namespace simuli::test {

/// Polynomials of degrees 2 and 4; the inverse polynomials are approximate, as in calibrations.
inline Windshield glass_before_the_lens() {
  return {Windshield::Reference::kForward,
          {0.0021, 1.004, -0.0006, 0.0009, 0.006, 0.0012},
          {-0.0032,
           0.0007,
           0.0002,
           -0.0001,
           0.0008,
           1.009,
           -0.0015,
           0.008,
           -0.0004,
           0.018,
           -0.003,
           0.006,
           0.017,
           -0.0036,
           0.007},
          {-0.0021, 0.996, 0.0006, -0.0009, -0.006, -0.0012},
          {0.0032,
           -0.0007,
           -0.0002,
           0.0001,
           -0.0008,
           0.991,
           0.0015,
           -0.008,
           0.0004,
           -0.018,
           0.003,
           -0.006,
           -0.017,
           0.0036,
           -0.007}};
}

/// Returns the same glass defined by the inverse polynomials.
inline Windshield glass_by_its_way_back() {
  Windshield glass = glass_before_the_lens();
  glass.reference = Windshield::Reference::kBackward;
  return glass;
}

}  // namespace simuli::test
