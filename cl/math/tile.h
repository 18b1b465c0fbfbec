// tile.h - a tile: its vectors of rays, its list of particles, and the responses of rays to particles.
#ifndef SIMULI_CL_MATH_TILE_H
#define SIMULI_CL_MATH_TILE_H
#include "math/response.h"
#include "shared/sensor_constants.h"

// Rays of a tile in this build; at most SIM_TILE_RAYS.
#define SIM_WALK_RAYS (V * NR * LS)
#if NR > 32
#error "active vectors are the bits of an uint"
#endif

// First slot of vector j of this work-item, from the tile's first slot on, and its ray block.
#define SIM_VECTOR_SLOT(j, lid) (((j)*LS + (lid)) * V)
#define SIM_VECTOR_ROW(j, lid) (SIM_VECTOR_SLOT(j, lid) / SIM_RAY_BLOCK)

/// Ray blocks that a pair touches, one bit each.
FN uint rows_of(uint payload) {
  const uint first = payload >> SIM_PARTICLE_BITS & 15u, last = payload >> (SIM_PARTICLE_BITS + 4);
#if SENSOR == SENSOR_CAMERA
  // Block columns, repeated for each row of blocks.
  const uint columns = (2u << (last & 3u)) - (1u << (first & 3u));
  return columns * (0x1111u & ((2u << (last | 3u)) - (1u << (first & 12u))));
#else
  return (2u << last) - (1u << first);
#endif
}

/// Whether vector j of a work-item lies in one of the ray blocks `rows` (one bit each).
FN uint touches(uint rows, int j, uint lid) { return rows >> SIM_VECTOR_ROW(j, lid) & 1u; }

/// Vectors of a work-item that the pair touches, one bit each.
FN uint vectors_of(uint payload, uint lid) {
  uint rows = rows_of(payload);
#if LS == 1 && V == SIM_RAY_BLOCK
  return rows;
#elif LS == 1 && 2 * V == SIM_RAY_BLOCK
  rows = (rows | rows << 8) & 0x00ff00ffu;
  rows = (rows | rows << 4) & 0x0f0f0f0fu;
  rows = (rows | rows << 2) & 0x33333333u;
  rows = (rows | rows << 1) & 0x55555555u;
  return rows | rows << 1;
#else
  uint vectors = 0;
  SIM_EACH(j, NR) vectors |= touches(rows, j, lid) << j;
  return vectors;
#endif
}

// Loops over a work-item's vectors. Unrolled on GPUs (several work-items per tile), so that vectors stay in
// registers; an array with a variable index would be in memory.
#if LS > 1
#define SIM_EACH_VECTOR _Pragma("unroll")
#else
#define SIM_EACH_VECTOR
#endif
// Loops over the vectors in the bit mask `vectors`, which is consumed.
#if LS > 1
#define SIM_EACH_VECTOR_OF(j, vectors) \
  SIM_EACH(j, NR)                      \
    if (vectors >> j & 1u)
#else
#define SIM_LOWEST(bits) ((int)(31u - clz(bits & -bits)))
#define SIM_EACH_VECTOR_OF(j, vectors) \
  for (int j = SIM_LOWEST(vectors); vectors != 0; vectors &= vectors - 1, j = SIM_LOWEST(vectors))
#endif

#if LS > 1
// Loads a record in four aligned loads of 16 bytes instead of 16 of four.
typedef REAL_VECTOR(4) Quarter;
#define SIM_QUARTERS (SIM_RECORD / 4)
FN void split_quarter(Quarter quarter, real* to) {
  to[0] = quarter.x;
  to[1] = quarter.y;
  to[2] = quarter.z;
  to[3] = quarter.w;
}
FN void load_record(__global const real* source, real* record) {
  __global const Quarter* quarters = (__global const Quarter*)source;
  SIM_EACH(k, SIM_QUARTERS) split_quarter(quarters[k], record + 4 * k);
}
/// Copies records of a batch to and from the group's local memory.
FN void stage_record(__global const real* source, __local Quarter* staged, uint i) {
  __global const Quarter* quarters = (__global const Quarter*)source;
  SIM_EACH(k, SIM_QUARTERS) staged[i * SIM_QUARTERS + k] = quarters[k];
}
FN void staged_record(const __local Quarter* staged, uint i, real* record) {
  SIM_EACH(k, SIM_QUARTERS) split_quarter(staged[i * SIM_QUARTERS + k], record + 4 * k);
}
#else
FN void load_record(__global const real* source, real* record) {
  SIM_EACH(k, SIM_RECORD) record[k] = source[k];
}
#endif

/// A tile from the point of view of one of its work-items.
typedef struct {
  uint lid;
  uint base;        // first slot
  uint begin, end;  // of its list in payload
  real u;           // position along x
  real t_min, t_max;
  real t_cut, log_cut;  // cuts of transmittance and of alpha
  __global const uint* payload;
  __global const real* records;
  __global const real* motions;
} Tile;

FN Tile tile_at(uint tile,
                __global const SensorConstants* sensor,
                __global const real* ray_u,
                __global const uint* first,
                __global const uint* payload,
                __global const real* records,
                __global const real* motions) {
  Tile at;
  at.lid = get_local_id(0);
  at.base = tile * SIM_WALK_RAYS;
  at.begin = first[tile];
  at.end = first[tile + 1];
  at.u = ray_u[at.base];
  at.t_min = sensor->model.t_min;
  at.t_max = sensor->model.t_max;
  at.t_cut = sensor->transmittance_cut;
  at.log_cut = log(sensor->alpha_cut);
  at.payload = payload;
  at.records = records;
  at.motions = motions;
  return at;
}

/// A particle in a tile's list: a tile-Gaussian pair.
typedef struct {
  uint place;   // in the list
  uint packed;  // payload: the particle and its ray blocks
  uint particle;
  real record[SIM_RECORD];
  real box_mean;  // the nearer to the tile of the record's two positions
#if ACTOR_MOTION
  int moves;  // during the frame
  real motion[SIM_MOTION];
#endif
} TilePair;

#if ACTOR_MOTION
/// Returns whether the record's particle moves during the frame, and makes the record's box comparable.
FN int take_box(real* record) {
  const int moves = record[SIM_R_BOX_HALF] < R(0.0);
  record[SIM_R_BOX_HALF] = fabs(record[SIM_R_BOX_HALF]);
  return moves;
}
#endif

/// Derives the other members from the payload and the record in `at`. `always`: also loads the motion of
/// particles at rest.
FN void complete(const Tile* tile, uint place, uint packed, int always, TilePair* at) {
  at->place = place;
  at->packed = packed;
  at->particle = packed & SIM_PARTICLE_MASK;
#if ACTOR_MOTION
  at->moves = take_box(at->record);
  if (always || at->moves) {
    SIM_EACH(k, SIM_MOTION) at->motion[k] = tile->motions[(ulong)at->particle * SIM_MOTION + k];
  }
#endif
  at->box_mean = nearest_box_mean(at->record, tile->u);
}

/// Loads a pair by its list position from global memory.
FN void load_pair(const Tile* tile, uint place, TilePair* at) {
  const uint packed = tile->payload[tile->begin + place];
  load_record(tile->records + (ulong)(packed & SIM_PARTICLE_MASK) * SIM_RECORD, at->record);
  complete(tile, place, packed, 0, at);
}

/// Returns the rays in the particle's frame of reference: the rays themselves, or `own` for moving particles.
/// On CPUs copies slow the backward pass by a factor of 1.4; on GPUs values are in registers.
FN const RayLanes* seen_by(const TilePair* at, const RayLanes* ray, RayLanes* own) {
#if ACTOR_MOTION
  if (at->moves) {
    follow(ray, at->motion, own);
    return own;
  }
#endif
#if LS > 1
  *own = *ray;
  return own;
#else
  return ray;
#endif
}

FN void meet(const Tile* tile, const TilePair* at, const RayLanes* seen, Response* response) {
  respond(at->record, at->box_mean, seen, tile->t_min, tile->t_max, response);
}

/// Terminates rays: they hit nothing any more.
FN void end_rays(I done, RayLanes* ray) {
  SIM_EACH(k, 3) ray->d[k] = SEL(done, (F)R(0.0), ray->d[k]);
}

/// The bit of vector j if it has an active ray.
FN uint alive_bit(const RayLanes* ray, int j) {
  return (ANY(is_ray(ray->d[0], ray->d[1], ray->d[2])) ? 1u : 0u) << j;
}

/// Terminates rays of vector j, and clears its bit in `alive` when none is left.
FN void terminate_ray(I done, int j, RayLanes* ray, uint* alive) {
  if (!ANY(done)) return;
  end_rays(done, ray);
  if (!alive_bit(ray, 0)) *alive &= ~(1u << j);
}

#endif
