// render_bwd.cl - gradients of blending, one 16-real slot per instance. Launcher: host/render/backward/render_bwd.cpp
#include "math/response_bwd.h"

/// out slot_first[n]: how many slots a particle has, one per tile instance; its prefix sum tells where they begin.
///     By index, not in the order of the frame: neighbours in memory have neighbouring slots, so that what a tile
///     writes lies together and project_bwd reads one slot after the other.
__kernel void slot_counts(const uint n,
                          __global const uint* keys,
                          __global const Footprint* footprints,
                          __global uint* slot_first) {
  const uint i = get_global_id(0);
  if (i < n) slot_first[i] = keys[i] != 0xffffffffu ? SIM_TILES(footprints[i]) : 0;
}

/// Index of the slot of (particle, tile): a particle's slots are contiguous, tile row by tile row.
FN ulong gradient_slot(__global const Footprint* footprints,
                       __global const uint* slot_first,
                       uint particle,
                       uint tx,
                       uint ty) {
  const Footprint f = footprints[particle];
  const uint count = SIM_HIGH(f.columns);
  uint column = tx - SIM_LOW(f.columns);  // beyond count when tx lies before it, too
  if (column >= count) column = count + tx - SIM_LOW(f.others);
  const uint row = ty - SIM_LOW(f.tile_rows);
  return (ulong)slot_first[particle] + row * (count + SIM_HIGH(f.others)) + column;
}

#if LS == 1
/// Brings what the next instances touch, and where their sums go, near: particles of a tile lie all over memory,
/// and waiting for them would be a third of the time.
FN void fetch_ahead(__global const uint* payload,
                    uint i,
                    uint end,
                    __global const real* records,
                    __global const Footprint* footprints,
                    __global const uint* slot_first,
                    __global const real* grads,
                    uint tx,
                    uint ty) {
  if (i + 8 < end) {
    const uint particle = payload[i + 8] & SIM_PARTICLE_MASK;
    PREFETCH(records + (ulong)particle * SIM_RECORD);
    PREFETCH(footprints + particle);
    PREFETCH(slot_first + particle);
  }
  if (i + 4 < end) {
    const uint particle = payload[i + 4] & SIM_PARTICLE_MASK;
    PREFETCH(grads + SIM_GRAD * gradient_slot(footprints, slot_first, particle, tx, ty));
  }
}
#endif

/// Replays render front to back with the stored result: what lies behind a particle is the result minus
/// what has been summed so far. No atomics: an instance's sums go to its own slot (by particle, tile row by tile row).
/// Build: ERRORS = 1 to blend the rays' errors as well; RAY_ORDER = 1 where rays have orders of their own, which
/// replay_window has gone through: here it is still particle by particle.
/// Tiles from tile_first on.
/// in  as render; out[6][slots] of render; grad_out[5][slots]: dL/d(features, T, distance); with RAY_ORDER
///     replayed[places][2][TILE_RAYS] and replayed_to[tiles][LS][NR] of replay_window
///     footprints[N]; slot_first[N], the prefix sum of slot_counts
/// out grads[K][16]: dL/dA (9, times r), dL/do' (3, times r), dL/d ln sigma, dL/d features (3).
///     Every slot of every instance is written.
///     ERRORS: instance_error[K]: sum over its rays of weight x ray_error[slots]
__kernel GROUP void render_bwd(const FrameParams frame,
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
                         __global real* instance_error,
                         const uint tile_first,
                         __global const real* replayed,
                         __global const uint* replayed_to) {
  const uint tile = tile_first + get_group_id(0);
  const uint lid = get_local_id(0);
  const uint base = tile * TILE_RAYS;
  const real tile_u = ray_u[base];
  const uint tx = tile % frame.tiles_x;
  const uint ty = tile / frame.tiles_x;
  const real t_min = sensor->model.t_min;
  const real t_max = sensor->model.t_max;
#if !RAY_ORDER
  const real t_cut = sensor->transmittance_cut;
  const real log_cut = log(sensor->alpha_cut);
#endif

  const uint begin = first[tile], end = first[tile + 1];
#if RAY_ORDER
  uint to[NR];  // places of the list that vectors look at
  uint all_to = 0;
#else
  F transmittance[NR];
  F behind[NR];  // g . (what is still to come): features, distance and the last transmittance
#endif
#if LS == 1
  RayLanes ray[NR];
  F g0[NR], g1[NR], g2[NR], gd[NR];
#if ERRORS
  F error[NR];
#endif
  uint alive = 0;  // a bit per vector that still has a ray
#endif
  EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    const uint slot = base + VECTOR_SLOT(j, lid);
#if RAY_ORDER
    to[j] = replayed_to[(tile * LS + lid) * NR + j];
    all_to = max(all_to, to[j]);
#else
    transmittance[j] = (F)R(1.0);
    behind[j] = behind_of(out + slot, grad_out + slot, frame.slots);
#endif
#if LS == 1
    load_ray(world_ray, ray_u, frame.slots, slot, &ray[j]);
#if ERRORS
    error[j] = LDV(ray_error + slot);
#endif
    g0[j] = LDV(grad_out + slot);
    g1[j] = LDV(grad_out + frame.slots + slot);
    g2[j] = LDV(grad_out + 2 * frame.slots + slot);
    gd[j] = LDV(grad_out + SIM_O_DISTANCE * frame.slots + slot);
#if RAY_ORDER
    alive |= (to[j] > 0 ? 1u : 0u) << j;
#else
    alive |= (ANY(is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2])) ? 1u : 0u) << j;
#endif
#endif
  }

  uint i = begin;
#if LS > 1
  __local REAL_VECTOR(4) staged[BATCH * SIM_RECORD / 4];
  __local uint staged_payload[BATCH];
  __local ulong staged_slot[BATCH];
  __local uint met[BATCH * WORDS];
  __local uint row_first[BATCH + 1];  // of each instance
  __local real rows[ROWS * ROW];
  __local int group_alive;
  for (; i < end; i += BATCH) {
    const uint count = min((uint)BATCH, end - i);
    for (uint k = lid; k < count; k += LS) {
      const uint particle = payload[i + k] & SIM_PARTICLE_MASK;
      staged_payload[k] = payload[i + k];
      staged_slot[k] = gradient_slot(footprints, slot_first, particle, tx, ty);
      stage_record(records + (ulong)particle * SIM_RECORD, staged, k);
    }
    for (uint k = lid; k < BATCH * WORDS; k += LS) met[k] = 0;
    if (lid == 0) group_alive = 0;
    barrier(CLK_LOCAL_MEM_FENCE);

    // Which vectors meet which instances, a bit each; rays that end in this batch still count. A vector at a time, and
    // its rays fetched anew: registers hold those of one.
    uint meets[NR];
    EACH_VECTOR
    for (int j = 0; j < NR; ++j) {
      meets[j] = 0;
      RayLanes ray;
      load_ray(world_ray, ray_u, frame.slots, base + VECTOR_SLOT(j, lid), &ray);
#if RAY_ORDER
      const uint last = min(count, max(to[j], i - begin) - (i - begin));
#else
      end_rays(transmittance[j] < t_cut, &ray);
      const uint last = ANY(is_ray(ray.d[0], ray.d[1], ray.d[2])) ? count : 0;
#endif
      if (last > 0) group_alive = 1;
      ONE_BY_ONE
      for (uint k = 0; k < last; ++k) {
        const uint packed = staged_payload[k];
        if (J_OUTSIDE(j, lid, packed)) continue;
        real record[SIM_RECORD];
        staged_record(staged, k, record);
        RayLanes seen = ray;
#if ACTOR_MOTION
        real motion[SIM_MOTION];
        if (take_motion(record, motions, packed & SIM_PARTICLE_MASK, motion)) seen = follow(&ray, motion);
#endif
        Response response;
        respond(record, nearest_box_mean(record, tile_u), &seen, t_min, t_max, &response);
        if (!ANY(response.inside)) continue;
        meets[j] |= 1u << k;
        atomic_or(&met[k * WORDS + lid / 32], 1u << lid % 32);
      }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    if (!group_alive) break;
    for (uint k = lid; k <= count; k += LS) {
      uint before = 0;
      ONE_BY_ONE
      for (uint w = 0; w < k * WORDS; ++w) before += popcount(met[w]);
      row_first[k] = before;
    }
    barrier(CLK_LOCAL_MEM_FENCE);

    const uint all_rows = row_first[count];
    uint begun = BATCH;  // the instance whose row this work-item has begun
    for (uint done_rows = 0; done_rows == 0 || done_rows < all_rows; done_rows += ROWS) {
      ONE_BY_ONE
      for (;;) {
        // What this work-item has next, by instance, then by vector. Others are elsewhere: one text for all.
        uint left_to_do = 0;
        EACH_VECTOR
        for (int j = 0; j < NR; ++j) left_to_do |= meets[j];
        if (left_to_do == 0) break;
        const uint k = 31u - clz(left_to_do & -left_to_do);
        const uint row = row_first[k] + rows_before(met + k * WORDS, lid) - done_rows;
        if (row >= ROWS) break;
        int j = NR - 1;
        EACH_VECTOR
        for (int v = NR - 2; v >= 0; --v) j = meets[v] >> k & 1u ? v : j;
        EACH_VECTOR
        for (int v = 0; v < NR; ++v) meets[v] &= ~(v == j ? 1u << k : 0u);
        __local real* own = rows + row * ROW;
        const int again = k == begun;
        begun = k;
        const uint slot = base + VECTOR_SLOT(j, lid);
        real record[SIM_RECORD];
        staged_record(staged, k, record);
        RayLanes seen;
        load_ray(world_ray, ray_u, frame.slots, slot, &seen);
#if !RAY_ORDER
        F left = pick(transmittance, j), to_come = pick(behind, j), d_log;
        end_rays(left < t_cut, &seen);
#endif
#if ACTOR_MOTION
        real motion[SIM_MOTION];
        if (read_motion(record, motions, staged_payload[k] & SIM_PARTICLE_MASK, motion)) seen = follow(&seen, motion);
#endif
        Response response;
        respond(record, nearest_box_mean(record, tile_u), &seen, t_min, t_max, &response);
        if (!ANY(response.inside)) {  // ended meanwhile
          for (int c = 0; !again && c < ROW; ++c) own[c] = R(0.0);
          continue;
        }
        const F h0 = LDV(grad_out + slot), h1 = LDV(grad_out + frame.slots + slot);
        const F h2 = LDV(grad_out + 2 * frame.slots + slot);
        const F hd = LDV(grad_out + SIM_O_DISTANCE * frame.slots + slot);
#if RAY_ORDER
        const __global real* weights =
            replayed + (ulong)(i + k - first[tile_first]) * REPLAYED + VECTOR_SLOT(j, lid);
        const F weight = LDV(weights);
        const F d_log = LDV(weights + TILE_RAYS);
#else
        const F weight = blend_back(record, &response, log_cut, h0, h1, h2, hd, &left, &to_come, &d_log);
        put_back(transmittance, j, left);
        put_back(behind, j, to_come);
#endif
        F sum[SIM_GRAD];
        for (int c = 0; c < SIM_GRAD; ++c) sum[c] = (F)R(0.0);
        add_gradients(record, &seen, &response, weight, d_log, h0, h1, h2, hd, sum);
        for (int c = 0; c < SIM_GRAD; ++c) own[c] = again ? own[c] + HSUM(sum[c]) : HSUM(sum[c]);
#if ERRORS
        const real blended_error = HSUM(weight * LDV(ray_error + slot));
        own[SIM_GRAD] = again ? own[SIM_GRAD] + blended_error : blended_error;
#endif
      }
      barrier(CLK_LOCAL_MEM_FENCE);
      // A work-item has the same columns of the same instances each time: what it has stored it may add to.
      ONE_BY_ONE
      for (uint place = lid; place < count * (SIM_GRAD + ERRORS); place += LS) {
        const uint k = place / (SIM_GRAD + ERRORS), column = place % (SIM_GRAD + ERRORS);
        const uint row = row_first[k], row_end = row_first[k + 1];
        const uint from = max(row, done_rows), to_row = min(row_end, done_rows + ROWS);
        if (from >= to_row && (row < row_end || done_rows > 0)) continue;  // of no row: a sum of nothing, once
        __global real* target = column < SIM_GRAD ? grads + SIM_GRAD * staged_slot[k] + column
                                                  : instance_error + staged_slot[k];
        const real total = column_sum(rows, column, from - done_rows, to_row - done_rows);
        *target = from > row ? *target + total : total;
      }
      barrier(CLK_LOCAL_MEM_FENCE);
    }
  }
#else
#if RAY_ORDER
  for (; i - begin < all_to; ++i) {
#else
  for (; i < end && alive; ++i) {
#endif
    fetch_ahead(payload, i, end, records, footprints, slot_first, grads, tx, ty);
    const uint packed = payload[i];
    const uint particle = packed & SIM_PARTICLE_MASK;
    real record[SIM_RECORD];
    load_record(records + (ulong)particle * SIM_RECORD, record);
#if ACTOR_MOTION
    real motion[SIM_MOTION];
    const int moves = take_motion(record, motions, particle, motion);
#endif
    const real box_mean = nearest_box_mean(record, tile_u);
    F sum[SIM_GRAD];
    for (int k = 0; k < SIM_GRAD; ++k) sum[k] = (F)R(0.0);
    F blended_error = (F)R(0.0);

    const int j_last = J_LAST(packed);
    for (int j = J_FIRST(packed); j <= j_last; ++j) {
      if (!(alive >> j & 1u)) continue;
      const RayLanes* seen = &ray[j];  // copies make a CPU's backward pass 1.4 times as slow
#if ACTOR_MOTION
      RayLanes followed;
      if (moves) {
        followed = follow(&ray[j], motion);
        seen = &followed;
      }
#endif
      Response response;
      respond(record, box_mean, seen, t_min, t_max, &response);
      const I inside = response.inside;
      if (!ANY(inside)) continue;
#if RAY_ORDER
      if (i - begin >= to[j]) continue;
      const __global real* weights =
          replayed + (ulong)(i - first[tile_first]) * REPLAYED + VECTOR_SLOT(j, lid);
      const F weight = LDV(weights);
      const F d_log = LDV(weights + TILE_RAYS);
#else
      F d_log;
      const F weight = blend_back(
          record, &response, log_cut, g0[j], g1[j], g2[j], gd[j], &transmittance[j], &behind[j], &d_log);
#endif
#if ERRORS
      blended_error = fma(weight, error[j], blended_error);
#endif
      add_gradients(record, seen, &response, weight, d_log, g0[j], g1[j], g2[j], gd[j], sum);

#if !RAY_ORDER
      const I done = AND(transmittance[j] < t_cut, inside);
      if (ANY(done)) {
        for (int k = 0; k < 3; ++k) ray[j].d[k] = SEL(done, (F)R(0.0), ray[j].d[k]);
        const I going = is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2]);
        if (!ANY(going)) alive &= ~(1u << j);
      }
#endif
    }

    const ulong slot = gradient_slot(footprints, slot_first, particle, tx, ty);
    __global real* target = grads + SIM_GRAD * slot;
#if V == 16
    vstore16(hsum16_each(sum), 0, target);
#else
    for (int k = 0; k < SIM_GRAD; ++k) target[k] = HSUM(sum[k]);
#endif
    if (ERRORS) instance_error[slot] = HSUM(blended_error);
  }
#endif
  // Behind the last contributor nothing was added: those slots are zero, not what the last frame left.
  for (i += lid; i < end; i += LS) {
    const uint particle = payload[i] & SIM_PARTICLE_MASK;
    const ulong slot = gradient_slot(footprints, slot_first, particle, tx, ty);
    __global real* target = grads + SIM_GRAD * slot;
    for (int k = 0; k < SIM_GRAD; ++k) target[k] = R(0.0);
    if (ERRORS) instance_error[slot] = R(0.0);
  }
}
