// sensor_constants.h - constants of a frame's sensor and actors for kernels. Structs as in reals.h. All angles
// in rad, lengths in m, times as shares of the frame; 3x3 matrices row-major.
#ifndef SIMULI_CL_SHARED_SENSOR_CONSTANTS_H
#define SIMULI_CL_SHARED_SENSOR_CONSTANTS_H

#include "reals.h"

#ifdef __cplusplus
namespace simuli::shared {
#endif

// Kinds of sensors (as SENSOR in builds).
#define SENSOR_CAMERA 0
#define SENSOR_LIDAR 1

// Lens model, the map from points in the camera frame to the picture: kinds (LENS in cl/math/camera.h) ...
#define SIM_LENS_PINHOLE 0
#define SIM_LENS_OPENCV_PINHOLE 1
#define SIM_LENS_OPENCV_FISHEYE 2
#define SIM_LENS_FTHETA 3          // image radius as a polynomial of the angle
#define SIM_LENS_FTHETA_INVERSE 4  // angle as a polynomial of the image radius
#define SIM_LENS_MEI 5
#define SIM_LENS_EQUIRECTANGULAR 6
#define SIM_LENS_DOUBLE_SPHERE 7
#define SIM_LENS_EUCM 8
// A polynomial of degree 5 in two variables a, b: rows of powers of a, 6 for b^0, 5 for b^1, ..., 1 for b^5.
#define SIM_BEND_TERMS 21
#define SIM_BEND_NONE 0
#define SIM_BEND_FORWARD 1   // the polynomials map rays from the world to the lens
#define SIM_BEND_BACKWARD 2  // the polynomials map rays from the lens to the world
// ... and constants. Angles are relative to the optical axis; radii are in focal lengths.
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
  // A windshield in front of the lens: SIM_BEND_.., the polynomials of both angles, those of the approximate
  // inverse, and the smallest cosine to the axis of rays that pass.
  real bend;
  real bend_cos_min;
  real bend_horizontal[SIM_BEND_TERMS], bend_vertical[SIM_BEND_TERMS];
  real bend_back_horizontal[SIM_BEND_TERMS], bend_back_vertical[SIM_BEND_TERMS];
}
SIM_REALS_END(LensConstants);

// Constants of a sensor's model, equal in all frames. Members of the other kind of sensor are 0.
SIM_REALS(ModelConstants) {
  real kappa;  // footprint variance per squared metre of range
  real t_min;
  real t_max;
  real period;        // of x: 2 pi for a LiDAR, the width of a periodic picture, else 0
  real time_step;     // from one row or column to the next later one
  real height;        // mean vertical offset of the beams
  real lever;         // largest distance of the beams' origins from that height
  real rays_per_rad;  // square root of rays per sr: on a camera's axis, LiDAR: mean

  // Cameras, in px.
  real fx, fy;
  real cx, cy;
  real picture_width, picture_height;
  real first_column, last_column, first_row, last_row;  // bounds of the requested pixels
  real time_x, time_y, time_c;                          // exposure = time_c + time_x * x + time_y * y
  real lens_cone;      // half angle of the cone about the axis in which the slopes hold
  real lens_slope[2];  // largest px per rad along x and y in the cone
  real lens_bend[2];   // largest second derivatives along great circles in the cone, px per rad^2
  SIM_REALS_OF(LensConstants) lens;

  // LiDARs. x is the spin angle since the sweep's start.
  real azimuth_cut;               // azimuth at which the sweep starts
  real spin;                      // +1 counter-clockwise, -1 clockwise
  real inv_span;                  // 1 / rad swept
  real time_first;                // time at which the sweep starts
  real time_spread;               // largest deviation of a ray's time from the time of its x
  real row_spread;                // largest deviation of a ray's elevation from its row's
  real lut_first, lut_scale;      // elevation of the look-up table's first bin, bins per rad
  real tile_first, tile_last;     // x where the first tile starts and the last one ends
  real tile_scale, tile_bins;     // bins of x per rad, and their number; column_of_bin maps a bin to its tile
  real mask_scale, mask_columns;  // columns of the ray mask per rad of x, and their number
}
SIM_REALS_END(ModelConstants);

// The drop function of a LiDAR (cl/math/ray_drop.h).
#define SIM_DROP_INPUTS 4
#define SIM_DROP_HIDDEN 8
SIM_REALS(DropConstants) {
  real skip[SIM_DROP_INPUTS];
  real bias;
  // Weights of each hidden value: by the inputs, and its bias.
  real hidden[SIM_DROP_HIDDEN * (SIM_DROP_INPUTS + 1)];
  real out[SIM_DROP_HIDDEN];
}
SIM_REALS_END(DropConstants);

// Constants of a sensor in one frame. o_ref is its centre at mid-frame.
SIM_REALS(SensorConstants) {
  real centre_ref[3];      // o_ref relative to the scene's origin
  real centre_step[3];     // centre at the end minus centre at the start
  real rotation_start[9];  // sensor_from_scene at the start
  real rotation_ref[9];    // at mid-frame
  real turn_axis[3];       // axis of the rotation from start to end, sensor frame
  real turn_angle;
  real cos_view,
      sin_view;  // camera: of the cone about the optical axis that contains everything visible at any time
  real alpha_cut;
  real transmittance_cut;
  real background[3];  // features
  real detail_reach;   // distance in m per metre of a particle that represents others (DETAIL)
  SIM_REALS_OF(DropConstants) drop;
  SIM_REALS_OF(ModelConstants) model;
}
SIM_REALS_END(SensorConstants);

// One for the background and one per actor: scene_from_actor at mid-frame and its change from start to end.
SIM_REALS(ActorConstants) {
  real centre[3];  // minus o_ref
  real step[3];    // origin at the end minus origin at the start
  real rotation[9];
  real turn_axis[3];  // axis of the rotation from start to end, scene axes
  real turn_angle;
  real there;  // factor of its particles' opacity; 0: not in this frame
  real reach;  // m, largest displacement by its shape in this frame
}
SIM_REALS_END(ActorConstants);

#ifdef __cplusplus
}  // namespace simuli::shared
#endif
#endif
