// render_bwd_groups.cl - gradients of blending for tiles of one work-group. Launcher: host/device/render/backward/render_bwd.cpp
#include "math/gradient_slot.h"
#include "math/response_bwd.h"

// A group processes its tile's list in batches: first it finds which work-items have rays that hit which pair,
// then it sums their gradients. Few work-items hit a pair, and only these have a row of sums, numbered by pair,
// then by work-item.
#define SIM_BATCH 32        // pairs; one bit each
#define SIM_BATCH_ROWS 128  // rows in local memory; a larger batch continues after these have been summed
#define SIM_ROW \
  (SIM_GRAD + 1)  // the last entry is the blended error; odd, so that columns lie in different banks
#define SIM_WORDS ((LS + 31) / 32)
// Compilers otherwise unroll loops over local memory and spend registers on each copy.
#define SIM_ONE_BY_ONE _Pragma("unroll 1")

/// State of a group's batch in local memory.
typedef struct {
  Quarter quarters[SIM_BATCH * SIM_QUARTERS];
  ulong slot[SIM_BATCH];
  uint payload[SIM_BATCH];
  uint rows_touched[SIM_BATCH];     // as rows_of(), computed once
  uint met[SIM_BATCH * SIM_WORDS];  // [pairs]: one bit per work-item that hits the pair
  uint row_count[SIM_BATCH];        // per pair
  uint row_first[SIM_BATCH + 1];
  real rows[SIM_BATCH_ROWS * SIM_ROW];
  int alive;
} Batch;

/// Kernel arguments common to all steps.
typedef struct {
  uint slots;
  __global const real* world_ray;
  __global const real* ray_u;
  __global const real* grad_out;
  __global const real* ray_error;
  __global const real* replayed;  // from the first entry of the list
} RayArrays;

/// State of a work-item's vectors. Rays are loaded again for each vector, because registers hold only one.
struct Blending {
#if RAY_ORDER
  uint to[NR];  // end of the list entries that each vector processes
#else
  F transmittance[NR];
  F behind[NR];  // g . (remaining features, distance and final transmittance)
#endif
  uint meets[NR];  // pairs of the batch, one bit each
};

/// Selects of[j] from registers; compilers turn of[k] with a variable k = j into a memory access.
FN F pick(const F* of, int j) {
  F one = of[0];
#pragma unroll
  for (int k = 1; k < NR; ++k) {
    const F other = of[k];
    one = k == j ? other : one;
  }
  return one;
}
FN void put_back(F* of, int j, F value) {
#pragma unroll
  for (int k = 0; k < NR; ++k) {
    const F was = of[k];
    of[k] = k == j ? value : was;
  }
}

/// Counts the rows of a pair before this work-item's. met[SIM_WORDS]: one bit per work-item.
FN uint rows_before(const __local uint* met, uint lid) {
  uint rows = 0;
  for (uint w = 0; w < lid / 32; ++w) rows += popcount(met[w]);
  return rows + popcount(met[lid / 32] & ((1u << lid % 32) - 1u));
}

/// Sums one column of the rows [begin, end), four at a time.
FN real column_sum(const __local real* rows, uint column, uint begin, uint end) {
  real part[4] = {R(0.0), R(0.0), R(0.0), R(0.0)};
  uint r = begin;
  SIM_ONE_BY_ONE
  for (; r + 4 <= end; r += 4) {
#pragma unroll
    for (int k = 0; k < 4; ++k) part[k] += rows[(r + k) * SIM_ROW + column];
  }
  SIM_ONE_BY_ONE
  for (; r < end; ++r) part[0] += rows[r * SIM_ROW + column];
  return (part[0] + part[1]) + (part[2] + part[3]);
}

FN void stage_batch(const Tile* tile, const SlotMap* map, uint first, uint count, __local Batch* batch) {
  for (uint k = tile->lid; k < count; k += LS) {
    const uint packed = tile->payload[tile->begin + first + k];
    const uint particle = packed & SIM_PARTICLE_MASK;
    batch->payload[k] = packed;
    batch->rows_touched[k] = rows_of(packed);
    batch->slot[k] = gradient_slot(map, particle);
    stage_record(tile->records + (ulong)particle * SIM_RECORD, batch->quarters, k);
  }
  for (uint k = tile->lid; k < SIM_BATCH * SIM_WORDS; k += LS) batch->met[k] = 0;
  if (tile->lid == 0) batch->alive = 0;
}

/// Finds which vectors hit which pairs of the batch that starts at list entry `first`; rays that terminate in
/// this batch still count. One vector at a time.
FN void find_met(const Tile* tile,
                 const RayArrays* arrays,
                 uint first,
                 uint count,
                 struct Blending* b,
                 __local Batch* batch) {
  SIM_EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    b->meets[j] = 0;
    RayLanes ray;
    load_ray(
        arrays->world_ray, arrays->ray_u, arrays->slots, tile->base + SIM_VECTOR_SLOT(j, tile->lid), &ray);
#if RAY_ORDER
    const uint last = min(count, max(b->to[j], first) - first);
#else
    end_rays(b->transmittance[j] < tile->t_cut, &ray);
    const uint last = alive_bit(&ray, 0) ? count : 0;
#endif
    if (last > 0) batch->alive = 1;
    SIM_ONE_BY_ONE
    for (uint k = 0; k < last; ++k) {
      if (!touches(batch->rows_touched[k], j, tile->lid)) continue;
      TilePair at;
      staged_record(batch->quarters, k, at.record);
      complete(tile, first + k, batch->payload[k], 0, &at);
      RayLanes own;
      Response response;
      meet(tile, &at, seen_by(&at, &ray, &own), &response);
      if (!ANY(response.inside)) continue;
      b->meets[j] |= 1u << k;
      atomic_or(&batch->met[k * SIM_WORDS + tile->lid / 32], 1u << tile->lid % 32);
    }
  }
}

FN void count_rows(uint lid, uint count, __local Batch* batch) {
  for (uint k = lid; k < count; k += LS) {
    uint own = 0;
    for (int w = 0; w < SIM_WORDS; ++w) own += popcount(batch->met[k * SIM_WORDS + w]);
    batch->row_count[k] = own;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint k = lid; k <= count; k += LS) {
    uint before = 0;
    SIM_ONE_BY_ONE
    for (uint i = 0; i < k; ++i) before += batch->row_count[i];
    batch->row_first[k] = before;
  }
}

/// Writes the gradients of vector j for pair k to a row, or with `again` adds them.
FN void add_row(const Tile* tile,
                const RayArrays* arrays,
                uint place,
                uint k,
                int j,
                int again,
                struct Blending* b,
                const __local Batch* batch,
                __local real* row) {
  const uint slots = arrays->slots, slot = tile->base + SIM_VECTOR_SLOT(j, tile->lid);
  TilePair at;
  staged_record(batch->quarters, k, at.record);
  RayLanes ray, own;
  load_ray(arrays->world_ray, arrays->ray_u, slots, slot, &ray);
#if !RAY_ORDER
  F left = pick(b->transmittance, j), to_come = pick(b->behind, j), d_log;
  end_rays(left < tile->t_cut, &ray);
#endif
  // Loads the motion for all pairs: loading it for some only would need registers for both cases.
  complete(tile, place, batch->payload[k], 1, &at);
  const RayLanes* seen = seen_by(&at, &ray, &own);
  Response response;
  meet(tile, &at, seen, &response);
  if (!ANY(response.inside)) {  // the ray terminated earlier
    for (int c = 0; !again && c < SIM_ROW; ++c) row[c] = R(0.0);
    return;
  }
  __global const real* grad_out = arrays->grad_out + slot;
  const F g0 = LDV(grad_out), g1 = LDV(grad_out + slots), g2 = LDV(grad_out + 2 * slots);
  const F gd = LDV(grad_out + SIM_O_DISTANCE * slots);
#if RAY_ORDER
  const __global real* weights =
      arrays->replayed + (ulong)place * SIM_REPLAYED + SIM_VECTOR_SLOT(j, tile->lid);
  const F weight = LDV(weights);
  const F d_log = LDV(weights + SIM_WALK_RAYS);
#else
  const F weight = blend_back(at.record, &response, tile->log_cut, g0, g1, g2, gd, &left, &to_come, &d_log);
  put_back(b->transmittance, j, left);
  put_back(b->behind, j, to_come);
#endif
  F sum[SIM_GRAD];
  for (int c = 0; c < SIM_GRAD; ++c) sum[c] = (F)R(0.0);
  add_gradients(at.record, seen, &response, weight, d_log, g0, g1, g2, gd, sum);
  for (int c = 0; c < SIM_GRAD; ++c) row[c] = again ? row[c] + HSUM(sum[c]) : HSUM(sum[c]);
#if ERRORS
  const real error = HSUM(weight * LDV(arrays->ray_error + slot));
  row[SIM_GRAD] = again ? row[SIM_GRAD] + error : error;
#endif
}

/// Fills the rows [done, done + SIM_BATCH_ROWS) of this work-item. begun: the pair whose row has been started.
FN void fill_rows(const Tile* tile,
                  const RayArrays* arrays,
                  uint first,
                  uint done,
                  uint* begun,
                  struct Blending* b,
                  __local Batch* batch) {
  SIM_ONE_BY_ONE
  for (;;) {
    // Continues with this work-item's next pair, then its next vector. Work-items are at different positions in
    // the same loop.
    uint left_to_do = 0;
    SIM_EACH_VECTOR
    for (int j = 0; j < NR; ++j) left_to_do |= b->meets[j];
    if (left_to_do == 0) break;
    const uint k = 31u - clz(left_to_do & -left_to_do);
    const uint row = batch->row_first[k] + rows_before(batch->met + k * SIM_WORDS, tile->lid) - done;
    if (row >= SIM_BATCH_ROWS) break;
    int j = NR - 1;
    SIM_EACH_VECTOR
    for (int v = NR - 2; v >= 0; --v) j = b->meets[v] >> k & 1u ? v : j;
    SIM_EACH_VECTOR
    for (int v = 0; v < NR; ++v) b->meets[v] &= ~(v == j ? 1u << k : 0u);
    const int again = k == *begun;
    *begun = k;
    add_row(tile, arrays, first + k, k, j, again, b, batch, batch->rows + row * SIM_ROW);
  }
}

/// Adds the rows [done, done + SIM_BATCH_ROWS) to the gradient slots of their pairs. A work-item always has the
/// same columns of the same pairs, so it may add to its own stores.
FN void add_rows_up(uint lid,
                    uint count,
                    uint done,
                    const __local Batch* batch,
                    __global real* grads,
                    __global real* pair_error) {
  SIM_ONE_BY_ONE
  for (uint place = lid; place < count * (SIM_GRAD + ERRORS); place += LS) {
    const uint k = place / (SIM_GRAD + ERRORS), column = place % (SIM_GRAD + ERRORS);
    const uint row = batch->row_first[k], row_end = batch->row_first[k + 1];
    const uint from = max(row, done), to = min(row_end, done + SIM_BATCH_ROWS);
    if (from >= to && (row < row_end || done > 0)) continue;  // a pair without rows: stores zeros once
    __global real* target =
        column < SIM_GRAD ? grads + SIM_GRAD * batch->slot[k] + column : pair_error + batch->slot[k];
    const real total = column_sum(batch->rows, column, from - done, to - done);
    *target = from > row ? *target + total : total;
  }
}

/// Contract as in render_bwd_lanes.cl.
__kernel SIM_GROUP void render_bwd(const FrameParams frame,
                                   __global const SensorConstants* sensor,
                                   __global const real* world_ray,
                                   __global const real* ray_u,
                                   __global const uint* first,
                                   __global const uint* payload,
                                   __global const real* records,
                                   __global const real* motions,
                                   __global const Footprint* footprints,
                                   __global const uint* slot_first,
                                   __global const real* out,
                                   __global const real* grad_out,
                                   __global real* grads,
                                   __global const real* ray_error,
                                   __global real* pair_error,
                                   const uint tile_first,
                                   __global const real* replayed,
                                   __global const uint* replayed_to) {
  const uint group = tile_first + get_group_id(0);
  const Tile tile = tile_at(group, sensor, ray_u, first, payload, records, motions);
  const SlotMap map = {group % frame.tiles_x, group / frame.tiles_x, footprints, slot_first};
  RayArrays arrays = {frame.slots, world_ray, ray_u, grad_out, ray_error, replayed};
  struct Blending b;
#if RAY_ORDER
  arrays.replayed += (ulong)(tile.begin - first[tile_first]) * SIM_REPLAYED;
#endif
  SIM_EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
#if RAY_ORDER
    b.to[j] = replayed_to[(group * LS + tile.lid) * NR + j];
#else
    const uint slot = tile.base + SIM_VECTOR_SLOT(j, tile.lid);
    b.transmittance[j] = (F)R(1.0);
    b.behind[j] = behind_of(out + slot, grad_out + slot, frame.slots);
#endif
  }

  __local Batch batch;
  const uint places = tile.end - tile.begin;
  uint place = 0;
  for (; place < places; place += SIM_BATCH) {
    const uint count = min((uint)SIM_BATCH, places - place);
    barrier(CLK_LOCAL_MEM_FENCE);
    stage_batch(&tile, &map, place, count, &batch);
    barrier(CLK_LOCAL_MEM_FENCE);
    find_met(&tile, &arrays, place, count, &b, &batch);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (!batch.alive) break;
    count_rows(tile.lid, count, &batch);
    uint begun = SIM_BATCH, all_rows = 0;
    for (uint done = 0; done == 0 || done < all_rows; done += SIM_BATCH_ROWS) {
      // The barrier comes before a loop of data-dependent length: compilers merge two loops that start at the
      // same place, and NVIDIA's then lets part of a warp pass the barrier below while the rest still fills
      // rows.
      barrier(CLK_LOCAL_MEM_FENCE);
      all_rows = batch.row_first[count];
      fill_rows(&tile, &arrays, place, done, &begun, &b, &batch);
      barrier(CLK_LOCAL_MEM_FENCE);
      add_rows_up(tile.lid, count, done, &batch, grads, pair_error);
    }
  }
  clear_slots(&map, payload, tile.begin + place, tile.end, grads, pair_error);
}
