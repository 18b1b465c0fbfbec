// layout.h - record layouts and launch structs shared by host C++ and OpenCL C. Only 4-byte scalars. The guard
// is __cplusplus, because plain clang does not define __OPENCL_VERSION__.
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

// A tile has FrameParams.tile_rays slots, 32 to 256, in ray blocks of 16. A ray block is the finest unit
// selected by a particle's footprint: for a LiDAR up to 16 consecutive firings of one beam, for a camera 4 x 4
// pixels, row by row, because footprints are about as wide as high (docs/METHOD.md section 5).
#define SIM_TILE_RAYS 256
#define SIM_RAY_BLOCK 16
// Cameras: sides in px of a tile and of a block. Blocks of a tile are stored row by row.
#define SIM_TILE_SIDE 16
#define SIM_BLOCK_SIDE 4
#define SIM_TILE_BLOCKS (SIM_TILE_SIDE / SIM_BLOCK_SIDE)
// Slot of pixel (x, y) with `tiles_x` tiles per row: the sum of a term of its row and a term of its column.
#define SIM_SLOT_OF_COLUMN(x)                                                                   \
  ((x) / SIM_TILE_SIDE * SIM_TILE_RAYS + (x) % SIM_TILE_SIDE / SIM_BLOCK_SIDE * SIM_RAY_BLOCK + \
   (x) % SIM_BLOCK_SIDE)
#define SIM_SLOT_OF_ROW(y, tiles_x)                                         \
  ((y) / SIM_TILE_SIDE * (tiles_x)*SIM_TILE_RAYS +                          \
   (y) % SIM_TILE_SIDE / SIM_BLOCK_SIDE * SIM_TILE_BLOCKS * SIM_RAY_BLOCK + \
   (y) % SIM_BLOCK_SIDE * SIM_BLOCK_SIDE)

// Rows of the parameter matrix (host/core/scene/gaussians.hpp), each of `stride` reals.
#define SIM_MEAN 0
#define SIM_LOG_SCALE 3
#define SIM_ROTATION 6
#define SIM_OPACITY 10
#define SIM_SH 11

// One blending record per particle, 16 reals. With o_g = M (o_ref - mu), M = diag(1/s^) R^T, r = |o_g| and Q
// the orthogonal map that takes o_g to -r e3 and makes the last entry of the first row 0: the 8 other entries
// of A = Q M / r, r^2, the largest contributing squared distance, features, and the box along x: where x is
// periodic a particle has two positions (at a sweep's start and end), otherwise the same one twice.
#define SIM_RECORD 16
#define SIM_R_MATRIX 0
#define SIM_R_RADIUS2 8
#define SIM_R_QMAX 9
#define SIM_R_FEATURE 10
#define SIM_R_BOX_MEAN 13
#define SIM_R_BOX_OTHER 14
#define SIM_R_BOX_HALF 15

// One gradient slot per pair, 16 reals, in the summation order of render_bwd.
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
#define SIM_O_DROP 6  // LiDARs: ln(p / (1 - p)) with p the probability of no return
#define SIM_OUTPUTS 7

// Payload of a pair: particle in the low 24 bits, first and last ray block in the high 8 (cameras: two opposite
// corner blocks).
#define SIM_PARTICLE_BITS 24
#define SIM_PARTICLE_MASK 0xffffffu

// Standard normal triples of the Monte Carlo projection, the same for all particles.
#define SIM_MONTE_CARLO 200

// Motion record of a particle whose actor moves during the frame: its velocity (m per frame) at the time of the
// blending record. Such particles have a negative SIM_R_BOX_HALF.
#define SIM_M_VELOCITY 0
#define SIM_M_TIME 3  // share of the frame
#define SIM_MOTION 4

// Rows of the gradient by the pose of a particle's actor.
#define SIM_P_SHIFT 0  // scene axes
#define SIM_P_TURN 3   // rotation vector about the actor's origin, scene axes
#define SIM_POSE_GRAD 6

// Rows of levels of detail (host/device/render/levels/levels.hpp), m.
#define SIM_DETAIL_FROM 0
#define SIM_DETAIL_UNTIL 1
#define SIM_DETAIL 2
#define SIM_DETAIL_FADE \
  1.125  // all there, or all gone, at this many times the distance where it begins to be

// Header of an actor's deformation grid, before the node offsets.
#define SIM_D_HALF 0   // half sides of its box, m
#define SIM_D_NODES 3  // nodes along them
#define SIM_D_HEADER 6

// Integers of one frame, passed by value.
typedef struct {
  sim_u32 particles;  // N
  sim_u32 stride;     // reals per parameter row, a multiple of 16, >= N
  sim_u32 tiles_x;
  sim_u32 tiles_y;
  sim_u32 rows;       // sensor rows: pixel rows or beams
  sim_u32 tile_rays;  // slots of a tile: V * NR * LS of the blending kernels
  sim_u32 row_slots;  // ray blocks per sensor row; 0 for blocks of pixels
  sim_u32 slots;      // tiles_x * tiles_y * tile_rays
} FrameParams;
SIM_CHECK_SIZE(FrameParams, 32);

// Tiles and sensor rows that one particle may touch: up to two intervals of tile columns, one for each position
// along x; none for a culled particle. An interval: first tile column | first block column in it << 12 | last
// block column in the last tile << 14 | tile columns << 16.
typedef struct {
  sim_u32 columns;
  sim_u32 others;     // second interval; 0: none
  sim_u32 rows;       // first sensor row | last sensor row << 16
  sim_u32 tile_rows;  // first tile row | tile rows << 16
} Footprint;
SIM_CHECK_SIZE(Footprint, 16);
#define SIM_LOW(packed) ((packed)&0xffffu)
#define SIM_HIGH(packed) ((packed) >> 16)
#define SIM_MOST_TILE_COLUMNS 0x1000u  // 65536 px
#define SIM_TILE_COLUMN(columns) ((columns)&0xfffu)
// First block column in the first tile, and last in the last tile. LiDARs: 0, and the last of a tile.
#define SIM_FIRST_IN_TILE(columns) ((columns) >> 12 & 3u)
#define SIM_LAST_IN_TILE(columns) ((columns) >> 14 & 3u)
// The same, counted from the sensor's first block column.
#define SIM_FIRST_BLOCK(columns) (SIM_TILE_COLUMN(columns) * SIM_TILE_BLOCKS + SIM_FIRST_IN_TILE(columns))
#define SIM_LAST_BLOCK(columns) \
  ((SIM_TILE_COLUMN(columns) + SIM_HIGH(columns) - 1) * SIM_TILE_BLOCKS + SIM_LAST_IN_TILE(columns))
#define SIM_COLUMNS(first_block, last_block)                                 \
  ((first_block) / SIM_TILE_BLOCKS | (first_block) % SIM_TILE_BLOCKS << 12 | \
   (last_block) % SIM_TILE_BLOCKS << 14 |                                    \
   ((last_block) / SIM_TILE_BLOCKS - (first_block) / SIM_TILE_BLOCKS + 1) << 16)
#define SIM_TILES(footprint) \
  ((SIM_HIGH((footprint).columns) + SIM_HIGH((footprint).others)) * SIM_HIGH((footprint).tile_rows))

#ifdef __cplusplus
}  // namespace simuli::shared
#endif
#endif
