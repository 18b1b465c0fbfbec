// layout.h - what host C++ and OpenCL C agree on: record layouts, tables of constants, launch structs.
// 4-byte scalars only. __cplusplus is the guard: plain clang does not define __OPENCL_VERSION__.
#ifndef SIMULI_CL_SHARED_LAYOUT_H
#define SIMULI_CL_SHARED_LAYOUT_H

#ifdef __cplusplus
#include <cstdint>
namespace simuli::shared {
using sim_u32 = std::uint32_t;
using sim_i32 = std::int32_t;
#define SIM_CHECK_SIZE(type, bytes) static_assert(sizeof(type) == (bytes), #type " has an unexpected size")
#else
typedef uint sim_u32;
typedef int sim_i32;
#define SIM_CHECK_SIZE(type, bytes) typedef char type##_size_check[sizeof(type) == (bytes) ? 1 : -1]
#endif

// A tile holds FrameParams.tile_rays slots, 32 to 256, in slot rows of 16. A slot row is the finest unit that a
// particle's footprint selects; for a camera it is one row of 16 pixels, for a LiDAR up to 16 neighbouring
// firings of one beam.
#define SIM_TILE_RAYS 256
#define SIM_SLOT_ROW 16
#define SIM_SLOT_ROWS 16

// Rows of the parameter matrix (host/scene/gaussians.hpp), each of `stride` reals.
#define SIM_MEAN 0
#define SIM_LOG_SCALE 3
#define SIM_ROTATION 6
#define SIM_OPACITY 10
#define SIM_SH 11

// One blending record per particle, 16 reals. With o_g = M (o_ref - mu), M = diag(1/s^) R^T, r = |o_g| and Q
// the orthogonal map that takes o_g to -r e3 and makes the last entry of the first row 0: the 8 other entries
// of A = Q M / r, r^2, the largest squared distance that still counts, features, and the box along the tile's
// x axis: a particle has two places there when x goes round (a sweep's start and end), else the same twice.
#define SIM_RECORD 16
#define SIM_R_MATRIX 0
#define SIM_R_RADIUS2 8
#define SIM_R_QMAX 9
#define SIM_R_FEATURE 10
#define SIM_R_BOX_MEAN 13
#define SIM_R_BOX_OTHER 14
#define SIM_R_BOX_HALF 15

// One gradient slot per instance, 16 reals, in the order in which render_bwd sums them.
#define SIM_GRAD 16
#define SIM_G_MATRIX 0
#define SIM_G_ORIGIN 9
#define SIM_G_OPACITY 12
#define SIM_G_FEATURE 13

// Outputs of blending, one row of `slots` reals each.
#define SIM_O_FEATURE 0
#define SIM_O_TRANSMITTANCE 3
#define SIM_O_DISTANCE 4
#define SIM_O_MEDIAN 5
#define SIM_OUTPUTS 6

// Payload of an instance: particle in the low 24 bits, first and last slot row in the high 8.
#define SIM_PARTICLE_BITS 24
#define SIM_PARTICLE_MASK 0xffffffu

// Constants of one sensor at one frame, as reals (float or double with the build).
#define SIM_S_CENTRE_START 0   // world, m from the scene origin
#define SIM_S_CENTRE_STEP 3    // centre at the end minus centre at the start
#define SIM_S_CENTRE_REF 6     // centre half-way through the frame: o_ref
#define SIM_S_ROT_START 9      // sensor_from_world at the start, row-major 3x3
#define SIM_S_ROT_REF 18       // sensor_from_world half-way
#define SIM_S_AXIS 27          // of the turn from start to end, sensor frame
#define SIM_S_ANGLE 30         // rad, of that turn
#define SIM_S_KAPPA 31         // footprint variance per squared metre of range
#define SIM_S_ALPHA_CUT 32
#define SIM_S_T_MIN 33         // m
#define SIM_S_T_MAX 34         // m
#define SIM_S_TRANSMITTANCE_CUT 35
#define SIM_S_BACKGROUND 36    // 3 features
#define SIM_S_FX 39            // camera: px
#define SIM_S_FY 40
#define SIM_S_CX 41
#define SIM_S_CY 42
#define SIM_S_WIDTH 43
#define SIM_S_HEIGHT 44
#define SIM_S_COS_FOV 45       // of the cone about the optical axis that holds the picture
#define SIM_S_SIN_FOV 46
#define SIM_S_TIME_X 47        // camera: exposure fraction = c + x * px + y * py
#define SIM_S_TIME_Y 48
#define SIM_S_TIME_C 49
#define SIM_S_AZIMUTH_CUT 50   // LiDAR: rad, where the sweep starts
#define SIM_S_SPIN 51          // +1 counter-clockwise, -1 clockwise
#define SIM_S_INV_SPAN 52      // 1 / rad swept
#define SIM_S_TIME_FIRST 53    // share of the frame at which the sweep starts
#define SIM_S_HEIGHT_REF 54    // m, mean vertical offset of the beams
#define SIM_S_LEVER 55         // m, reach of the beams' origins about the reference
#define SIM_S_LUT_FIRST 56     // elevation of the look-up table's first bin
#define SIM_S_LUT_SCALE 57     // bins per rad
#define SIM_S_TILE_X0 58       // LiDAR: where the first tile starts, rad of x
#define SIM_S_TILE_SCALE 59    // LiDAR: bins per rad; a table tells the tile column of each
#define SIM_S_PERIOD 60        // of x: 2 pi for a LiDAR, the width of a picture that goes round, else 0
#define SIM_S_TIME_SPREAD 61   // rays fire at most this share of the frame before or after what x tells
#define SIM_S_ROW_SPREAD 62    // LiDAR: rad, rays' elevations are at most this off their row's
#define SIM_S_TIME_STEP 63     // share of the frame from one row or column to the next that is later
#define SIM_S_LENS 64          // camera: SIM_LENS_REALS constants of the lens
#define SIM_S_LENS_CONE 96     // camera: rad, half angle of the cone about the axis where the slopes hold
#define SIM_S_LENS_SLOPE_X 97  // largest px per rad there, along x and y
#define SIM_S_LENS_SLOPE_Y 98
#define SIM_S_TILE_BINS 99     // LiDAR: entries of column_of_bin
#define SIM_S_TILE_X1 100      // LiDAR: where the last tile ends, rad of x
#define SIM_S_MASK_SCALE 101   // LiDAR: columns of the ray mask per rad of x, and their number
#define SIM_S_MASK_COLUMNS 102
#define SIM_S_LENS_BEND_X 103  // largest second derivative there along any great circle, px per rad^2
#define SIM_S_LENS_BEND_Y 104
#define SIM_SENSOR_REALS 106
#define SIM_MONTE_CARLO 200    // Monte Carlo projection: as many standard normal triples follow the constants

// The map from points before a camera to its picture: kinds (as LENS in cl/math/camera.h) ...
#define SIM_LENS_PINHOLE 0
#define SIM_LENS_OPENCV_PINHOLE 1
#define SIM_LENS_OPENCV_FISHEYE 2
#define SIM_LENS_FTHETA 3           // image radius as a polynomial of the angle
#define SIM_LENS_FTHETA_INVERSE 4   // angle as a polynomial of the image radius
#define SIM_LENS_MEI 5
#define SIM_LENS_EQUIRECTANGULAR 6
#define SIM_LENS_DOUBLE_SPHERE 7
#define SIM_LENS_EUCM 8
// ... and constants. Angles are those off the optical axis; radii are in focal lengths.
#define SIM_L_COS_MIN 0       // MEI, double sphere, EUCM: points at smaller cosines have no image
#define SIM_L_ANGLE_MAX 1     // fisheye, F-theta: rad
#define SIM_L_RADIUS2_MAX 2   // OpenCV pinhole, MEI: squared radius before distortion
#define SIM_L_RADIUS_MAX 3    // inverse F-theta: image radius at the largest angle
#define SIM_L_DISTORTION 4    // OpenCV pinhole, MEI: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4
#define SIM_L_POLYNOMIAL 4    // fisheye: k1..k4; F-theta: coefficients of degree 1 to 5
#define SIM_L_LINEAR 9        // F-theta: c d e of the map [[c d] [e 1]]
#define SIM_L_XI 16           // MEI, double sphere
#define SIM_L_ALPHA 17        // double sphere, EUCM
#define SIM_L_BETA 18         // EUCM
#define SIM_LENS_REALS 32

// One row per actor behind a row for the background, in reals: scene_from_actor half-way through the frame and
// how it changes from start to end.
#define SIM_A_CENTRE 0     // minus o_ref, m
#define SIM_A_STEP 3       // centre at the end minus centre at the start
#define SIM_A_ROTATION 6   // row-major 3x3
#define SIM_A_AXIS 15      // of the turn from start to end, scene axes
#define SIM_A_ANGLE 18     // rad, of that turn
#define SIM_A_THERE 19     // 1, or 0: not in this frame
#define SIM_ACTOR_REALS 20

// Motion record of a particle whose actor moves during the frame: its velocity (m per frame) at the time at
// which the blending record holds. Such particles have a negative SIM_R_BOX_HALF.
#define SIM_M_VELOCITY 0
#define SIM_M_TIME 3  // share of the frame
#define SIM_MOTION 4

// Rows of the gradient by the pose of a particle's actor.
#define SIM_P_SHIFT 0  // scene axes
#define SIM_P_TURN 3   // rotation vector about the actor's origin, scene axes
#define SIM_POSE_GRAD 6

// Integers of one frame, passed by value.
typedef struct {
  sim_u32 particles;      // N
  sim_u32 stride;         // reals from one parameter row to the next, a multiple of 16, >= N
  sim_u32 tiles_x;
  sim_u32 tiles_y;
  sim_u32 rows;           // sensor rows: pixel rows or beams
  sim_u32 tile_rays;      // slots of a tile: V * NR * LS of the blending kernels
  sim_u32 row_slots;      // slot rows per sensor row: 1 for cameras
  sim_u32 slots;          // tiles_x * tiles_y * tile_rays
} FrameParams;
SIM_CHECK_SIZE(FrameParams, 32);

// The tiles and sensor rows that one particle may touch: up to two intervals of tile columns, one for each of
// its places along x. A culled particle has none.
typedef struct {
  sim_u32 columns;  // first tile column | tile columns << 16
  sim_u32 others;   // the same of the second interval; 0: none
  sim_u32 rows;     // first sensor row | last sensor row << 16
  sim_u32 tile_rows;  // first tile row | tile rows << 16
} Footprint;
SIM_CHECK_SIZE(Footprint, 16);
#define SIM_LOW(packed) ((packed) & 0xffffu)
#define SIM_HIGH(packed) ((packed) >> 16)
#define SIM_TILES(footprint) \
  ((SIM_HIGH((footprint).columns) + SIM_HIGH((footprint).others)) * SIM_HIGH((footprint).tile_rows))

#ifdef __cplusplus
}  // namespace simuli::shared
#endif
#endif
