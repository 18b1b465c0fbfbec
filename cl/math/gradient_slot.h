// gradient_slot.h - position of a pair's gradients: a particle's slots are consecutive, by tile row and tile
// column.
#ifndef SIMULI_CL_MATH_GRADIENT_SLOT_H
#define SIMULI_CL_MATH_GRADIENT_SLOT_H
#include "math/lanes.h"
#include "shared/layout.h"

/// A tile of the frame and the slots of its pairs: slot_first[N] is the prefix sum of slot_counts.
typedef struct {
  uint tx, ty;
  __global const Footprint* footprints;
  __global const uint* slot_first;
} SlotMap;

FN ulong gradient_slot(const SlotMap* map, uint particle) {
  const Footprint f = map->footprints[particle];
  const uint count = SIM_HIGH(f.columns);
  uint column = map->tx - SIM_TILE_COLUMN(f.columns);  // exceeds count also when tx lies before it
  if (column >= count) column = count + map->tx - SIM_TILE_COLUMN(f.others);
  const uint row = map->ty - SIM_LOW(f.tile_rows);
  return (ulong)map->slot_first[particle] + row * (count + SIM_HIGH(f.others)) + column;
}

/// Zeroes the slots of payload[begin, end), which follow the last contributing pair, by all work-items of the
/// group.
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
