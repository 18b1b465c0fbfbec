// cl/math/camera.h compiled for the host in the including namespace, which declares the number type F (and
// `real`, masks I, atan2_lanes()). Included once by each source of lenses; the definitions end with the file.
#define FN inline
#define R(x) x
#define REALS const F*
#define LENS_CONSTANTS const shared::LensConstants<F>*
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
#undef BEND_STEPS
