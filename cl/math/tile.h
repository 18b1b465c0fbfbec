// tile.h - a tile: its vectors of rays, its list of particles, and what one of these is to one of those.
#ifndef SIMULI_CL_MATH_TILE_H
#define SIMULI_CL_MATH_TILE_H
#include "math/response.h"
#include "shared/sensor_constants.h"

// Rays of a tile in this build: at most SIM_TILE_RAYS.
#define SIM_WALK_RAYS (V * NR * LS)
#if NR > 32
#error "vectors that have a ray are told by the bits of an uint"
#endif

// Slots of vector j of this work-item, from the tile's first slot, and its slot row.
#define SIM_VECTOR_SLOT(j, lid) (((j)*LS + (lid)) * V)
#define SIM_VECTOR_ROW(j, lid) (SIM_VECTOR_SLOT(j, lid) / SIM_SLOT_ROW)
#define SIM_ROW_FIRST(payload) ((payload) >> SIM_PARTICLE_BITS & 15u)
#define SIM_ROW_LAST(payload) ((payload) >> (SIM_PARTICLE_BITS + 4))

// The vectors of this work-item that a slot-row range touches: [SIM_J_FIRST, SIM_J_LAST]. With one work-item per
// tile they are consecutive; else every vector is tested.
#if LS == 1
#define SIM_J_FIRST(payload) ((int)(SIM_ROW_FIRST(payload) * (SIM_SLOT_ROW / V)))
#define SIM_J_LAST(payload) ((int)(SIM_ROW_LAST(payload) * (SIM_SLOT_ROW / V)) + SIM_SLOT_ROW / V - 1)
#define SIM_J_OUTSIDE(j, lid, payload) 0
// Bits of these vectors.
#define SIM_VECTORS_OF(payload) \
  (((2u << (SIM_J_LAST(payload) - SIM_J_FIRST(payload))) - 1u) << SIM_J_FIRST(payload))
#else
#define SIM_J_FIRST(payload) 0
#define SIM_J_LAST(payload) (NR - 1)
#define SIM_J_OUTSIDE(j, lid, payload) \
  (SIM_VECTOR_ROW(j, lid) < SIM_ROW_FIRST(payload) || SIM_VECTOR_ROW(j, lid) > SIM_ROW_LAST(payload))
#endif

// Loops over a work-item's vectors. Unrolled where there are several work-items (GPUs): what a vector has is in
// registers then, while an array indexed by a variable is in memory.
#if LS > 1
#define SIM_EACH_VECTOR _Pragma("unroll")
#else
#define SIM_EACH_VECTOR
#endif

#if LS > 1
// Records in four loads of 16 bytes, not in 16 of four: they are aligned to their size.
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
/// To and from the records of a batch that a group has in local memory.
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

/// A tile, as one of its work-items sees it.
typedef struct {
  uint lid;
  uint base;        // its first slot
  uint begin, end;  // of its list in payload
  real u;           // its place along x
  real t_min, t_max;
  real t_cut, log_cut;  // of transmittance, and of alpha
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

/// A particle in a tile's list.
typedef struct {
  uint place;   // in the list
  uint packed;  // payload: the particle and its slot rows
  uint particle;
  real record[SIM_RECORD];
  real box_mean;  // of the record's two the one that is nearer to the tile
#if ACTOR_MOTION
  int moves;  // during the frame
  real motion[SIM_MOTION];
#endif
} Instance;

#if ACTOR_MOTION
/// Whether the record's particle moves during the frame. The record's box is one to compare with afterwards.
FN int take_box(real* record) {
  const int moves = record[SIM_R_BOX_HALF] < R(0.0);
  record[SIM_R_BOX_HALF] = fabs(record[SIM_R_BOX_HALF]);
  return moves;
}
#endif

/// What follows from the payload and the record that `at` has. `always`: also the motion of what does not move.
FN void complete(const Tile* tile, uint place, uint packed, int always, Instance* at) {
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

/// The one of a place of the list, from global memory.
FN void load_instance(const Tile* tile, uint place, Instance* at) {
  const uint packed = tile->payload[tile->begin + place];
  load_record(tile->records + (ulong)(packed & SIM_PARTICLE_MASK) * SIM_RECORD, at->record);
  complete(tile, place, packed, 0, at);
}

/// Whether vector j has rays, by the bits of `alive`, in the particle's slot rows.
FN int is_touched(const Tile* tile, const Instance* at, int j, uint alive) {
  return !SIM_J_OUTSIDE(j, tile->lid, at->packed) && (alive >> j & 1u);
}

/// The rays as the particle sees them: themselves, or in `own`. Copies make a CPU's backward pass 1.4 times as slow;
/// on GPUs a value is in registers.
FN const RayLanes* seen_by(const Instance* at, const RayLanes* ray, RayLanes* own) {
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

FN void meet(const Tile* tile, const Instance* at, const RayLanes* seen, Response* response) {
  respond(at->record, at->box_mean, seen, tile->t_min, tile->t_max, response);
}

/// Rays that are done: they meet nothing any more.
FN void end_rays(I done, RayLanes* ray) {
  SIM_EACH(k, 3) ray->d[k] = SEL(done, (F)R(0.0), ray->d[k]);
}

/// The bit of vector j where it has a ray.
FN uint alive_bit(const RayLanes* ray, int j) {
  return (ANY(is_ray(ray->d[0], ray->d[1], ray->d[2])) ? 1u : 0u) << j;
}

/// Ends rays of vector j; without any left it is not `alive`.
FN void retire(I done, int j, RayLanes* ray, uint* alive) {
  if (!ANY(done)) return;
  end_rays(done, ray);
  if (!alive_bit(ray, 0)) *alive &= ~(1u << j);
}

#endif
