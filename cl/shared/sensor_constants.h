// sensor_constants.h - what a frame tells kernels of its sensor and of its actors. Structs as in reals.h.
// All angles in rad, lengths in m, times as shares of the frame; 3x3 matrices row-major.
#ifndef SIMULI_CL_SHARED_SENSOR_CONSTANTS_H
#define SIMULI_CL_SHARED_SENSOR_CONSTANTS_H

#include "reals.h"

#ifdef __cplusplus
namespace simuli::shared {
#endif

// Kinds of sensors (as SENSOR in builds).
#define SENSOR_CAMERA 0
#define SENSOR_LIDAR 1

// The map from points before a camera to its picture: kinds (as LENS in cl/math/camera.h) ...
#define SIM_LENS_PINHOLE 0
#define SIM_LENS_OPENCV_PINHOLE 1
#define SIM_LENS_OPENCV_FISHEYE 2
#define SIM_LENS_FTHETA 3          // image radius as a polynomial of the angle
#define SIM_LENS_FTHETA_INVERSE 4  // angle as a polynomial of the image radius
#define SIM_LENS_MEI 5
#define SIM_LENS_EQUIRECTANGULAR 6
#define SIM_LENS_DOUBLE_SPHERE 7
#define SIM_LENS_EUCM 8
// A polynomial of degree 5 in two variables a, b: rows of powers of a, 6 of b^0, 5 of b^1, ..., 1 of b^5.
#define SIM_BEND_TERMS 21
#define SIM_BEND_NONE 0
#define SIM_BEND_FORWARD 1   // the polynomials take rays from the world to the lens
#define SIM_BEND_BACKWARD 2  // from the lens to the world
// ... and constants. Angles are those off the optical axis; radii are in focal lengths.
SIM_REALS(LensConstants) {
  real cos_min;         // MEI, double sphere, EUCM: points at smaller cosines have no image
  real angle_max;       // fisheye, F-theta
  real radius2_max;     // OpenCV pinhole, MEI: squared radius before distortion
  real radius_max;      // inverse F-theta: image radius at the largest angle
  real distortion[12];  // OpenCV pinhole, MEI: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4
  real polynomial[5];   // fisheye: k1..k4; F-theta: coefficients of degree 1 to 5
  real linear[3];       // F-theta: c d e of the map [[c d] [e 1]]
  real xi;              // MEI, double sphere
  real alpha;           // double sphere, EUCM
  real beta;            // EUCM
  // A windshield before the lens: SIM_BEND_.., the polynomials of both angles, those of about the way back, and the
  // cosine off the axis above which rays get through.
  real bend;
  real bend_cos_min;
  real bend_horizontal[SIM_BEND_TERMS], bend_vertical[SIM_BEND_TERMS];
  real bend_back_horizontal[SIM_BEND_TERMS], bend_back_vertical[SIM_BEND_TERMS];
}
SIM_REALS_END(LensConstants);

// Of a sensor's model, the same in every frame. What the other kind of sensor has is 0.
SIM_REALS(ModelConstants) {
  real kappa;  // footprint variance per squared metre of range
  real t_min;
  real t_max;
  real period;        // of x: 2 pi for a LiDAR, the width of a picture that goes round, else 0
  real time_step;     // from one row or column to the next that is later
  real height;        // mean vertical offset of the beams
  real lever;         // reach of the beams' origins about that height
  real rays_per_rad;  // square root of rays per sr: at a lens's axis, in the mean of a LiDAR's

  // Cameras, in px.
  real fx, fy;
  real cx, cy;
  real picture_width, picture_height;
  real first_column, last_column, first_row, last_row;  // between which all pixels that are asked for lie
  real time_x, time_y, time_c;                          // exposure = time_c + time_x * x + time_y * y
  real lens_cone;      // half angle of the cone about the axis where the slopes hold
  real lens_slope[2];  // px per rad there along x and y, at most
  real lens_bend[2];   // second derivatives there along any great circle, px per rad^2, at most
  SIM_REALS_OF(LensConstants) lens;

  // LiDARs. x is the spin angle since the sweep's start.
  real azimuth_cut;               // where the sweep starts
  real spin;                      // +1 counter-clockwise, -1 clockwise
  real inv_span;                  // 1 / rad swept
  real time_first;                // at which the sweep starts
  real time_spread;               // rays fire at most this long before or after what x tells
  real row_spread;                // rays' elevations are at most this off their row's
  real lut_first, lut_scale;      // elevation of the look-up table's first bin, bins per rad
  real tile_first, tile_last;     // x where the first tile starts and the last one ends
  real tile_scale, tile_bins;     // bins of x per rad, and their number; column_of_bin tells the tile of each
  real mask_scale, mask_columns;  // columns of the ray mask per rad of x, and their number
}
SIM_REALS_END(ModelConstants);

// The drop function of a LiDAR (cl/math/ray_drop.h).
#define SIM_DROP_INPUTS 4
#define SIM_DROP_HIDDEN 8
SIM_REALS(DropConstants) {
  real skip[SIM_DROP_INPUTS];
  real bias;
  // Of each hidden value: by the inputs, and its own bias.
  real hidden[SIM_DROP_HIDDEN * (SIM_DROP_INPUTS + 1)];
  real out[SIM_DROP_HIDDEN];
}
SIM_REALS_END(DropConstants);

// Of a sensor in one frame. o_ref is its centre half-way.
SIM_REALS(SensorConstants) {
  real centre_ref[3];      // o_ref, from the scene's origin
  real centre_step[3];     // centre at the end minus centre at the start
  real rotation_start[9];  // sensor_from_scene at the start
  real rotation_ref[9];    // half-way
  real turn_axis[3];       // of the turn from start to end, sensor frame
  real turn_angle;
  real cos_view, sin_view;  // camera: of the cone about the optical axis that holds what is seen at any time
  real alpha_cut;
  real transmittance_cut;
  real background[3];  // features
  real detail_reach;   // m away for each m of a particle that is drawn in others' place (DETAIL)
  SIM_REALS_OF(DropConstants) drop;
  SIM_REALS_OF(ModelConstants) model;
}
SIM_REALS_END(SensorConstants);

// One for the background and one per actor: scene_from_actor half-way through the frame and how it changes from
// start to end.
SIM_REALS(ActorConstants) {
  real centre[3];  // minus o_ref
  real step[3];    // centre at the end minus centre at the start
  real rotation[9];
  real turn_axis[3];  // of the turn from start to end, scene axes
  real turn_angle;
  real there;  // of its particles' opacity; 0: not in this frame
  real reach;  // m, the farthest that its shape moves a point in this frame
}
SIM_REALS_END(ActorConstants);

#ifdef __cplusplus
}  // namespace simuli::shared
#endif
#endif
