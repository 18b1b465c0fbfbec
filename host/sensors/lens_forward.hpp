#pragma once
// cl/math/camera.h compiled for the host: F is a double, a mask is an int. Only the lens's own sources
// include this; the vocabulary ends with the file.
#include <cmath>

#include "cl/shared/sensor_constants.h"

namespace simuli::lens_forward {

using real = double;
using F = double;
using I = int;
using std::fma;
using std::sqrt;
inline F atan2_lanes(F y, F x) { return std::atan2(y, x); }

#define FN inline
#define R(x) x
#define REALS const double*
#define LENS_CONSTANTS const shared::LensConstants<double>*
#define SEL(c, a, b) ((c) ? (a) : (b))
#define AND(a, b) ((a) && (b))
#define ANY(c) (c)
#define VMIN(a, b) SEL((a) < (b), (a), (b))
#define VMAX(a, b) SEL((a) > (b), (a), (b))

#include "cl/math/camera.h"

#undef FN
#undef R
#undef REALS
#undef LENS_CONSTANTS
#undef SEL
#undef AND
#undef ANY
#undef VMIN
#undef VMAX
#undef CAMERA_NEAR
#undef PINHOLE_COS2_MIN
#undef FTHETA_MAX_ITERATIONS

}  // namespace simuli::lens_forward
