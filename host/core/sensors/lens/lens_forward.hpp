#pragma once
// cl/math/camera.h compiled for the host: F is a double, a mask is an int. Included only by sources of lenses.
#include <cmath>

#include "cl/shared/sensor_constants.h"

namespace simuli::lens_forward {

using real = double;
using F = double;
using I = int;
using std::fma;
using std::sqrt;
inline F atan2_lanes(F y, F x) { return std::atan2(y, x); }
inline void sincos_lanes(F x, F* sine, F* cosine) {
  *sine = std::sin(x);
  *cosine = std::cos(x);
}

#include "host/core/sensors/lens/lens_text.hpp"

}  // namespace simuli::lens_forward
