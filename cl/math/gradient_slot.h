// gradient_slot.h - where the gradients of pairs are: a particle's slots lie together, tile row by tile row.
#ifndef SIMULI_CL_MATH_GRADIENT_SLOT_H
#define SIMULI_CL_MATH_GRADIENT_SLOT_H
#include "math/lanes.h"
#include "shared/layout.h"

/// A tile of the frame, and its pairs' slots: slot_first[N] is the prefix sum of slot_counts.
typedef struct {
  uint tx, ty;
  __global const Footprint* footprints;
  __global const uint* slot_first;
} SlotMap;

FN ulong gradient_slot(const SlotMap* map, uint particle) {
  const Footprint f = map->footprints[particle];
  const uint count = SIM_HIGH(f.columns);
  uint column = map->tx - SIM_TILE_COLUMN(f.columns);  // beyond count when tx lies before it, too
  if (column >= count) column = count + map->tx - SIM_TILE_COLUMN(f.others);
  const uint row = map->ty - SIM_LOW(f.tile_rows);
  return (ulong)map->slot_first[particle] + row * (count + SIM_HIGH(f.others)) + column;
}

/// Zeros, not what the last frame left, in the slots of payload[begin, end), by all of the group's work-items: nothing
/// was added behind the last contributor.
FN void clear_slots(const SlotMap* map,
                    __global const uint* payload,
                    uint begin,
                    uint end,
                    __global real* grads,
                    __global real* pair_error) {
  for (uint i = begin + get_local_id(0); i < end; i += LS) {
    const ulong slot = gradient_slot(map, payload[i] & SIM_PARTICLE_MASK);
    SIM_EACH(k, SIM_GRAD) grads[SIM_GRAD * slot + k] = R(0.0);
    if (ERRORS) pair_error[slot] = R(0.0);
  }
}

#endif
