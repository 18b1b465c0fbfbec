// render_bwd.cl - gradients of blending, one 16-real slot per instance. Launcher: host/render/backward/render_bwd.cpp
#include "math/blend_bwd.h"

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

/// sum += A^T v, A the record's matrix, whose first row ends in 0.
FN void add_transposed(const real* record, const F* v, F* sum) {
  sum[0] = fma(v[0], (F)record[0], fma(v[1], (F)record[2], fma(v[2], (F)record[5], sum[0])));
  sum[1] = fma(v[0], (F)record[1], fma(v[1], (F)record[3], fma(v[2], (F)record[6], sum[1])));
  sum[2] = fma(v[1], (F)record[4], fma(v[2], (F)record[7], sum[2]));
}

/// Replays render front to back with the stored result: what lies behind a particle is the result minus
/// what has been summed so far. No atomics: an instance's sums go to its own slot (by particle, tile row by tile row).
/// Build: ERRORS = 1 to blend the rays' errors as well, RAY_GRADIENTS = 1 for those of the rays; RAY_ORDER = 1 where
/// rays have orders of their own, which replay_window has gone through: here it is still particle by particle.
/// Tiles from tile_first on.
/// in  as render; out[6][slots] of render; grad_out[5][slots]: dL/d(features, T, distance); with RAY_ORDER
///     replayed[places][2][TILE_RAYS] and replayed_to[tiles][LS][NR] of replay_window
///     footprints[N]; slot_first[N], the prefix sum of slot_counts
/// out grads[K][16]: dL/dA (9, times r), dL/do' (3, times r), dL/d ln sigma, dL/d features (3).
///     Every slot of every instance is written.
///     ERRORS: instance_error[K]: sum over its rays of weight x ray_error[slots]
///     RAY_GRADIENTS: ray_grads[3|6][slots]: dL/d(direction); with ORIGINS also dL/d(origin)
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
                         __global real* ray_grads,
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

  const uint begin = first[tile];
  RayLanes ray[NR];
#if RAY_ORDER
  uint to[NR];  // places of the list that vectors look at
  uint all_to = 0;
#else
  F transmittance[NR];
  F behind[NR];  // g . (what is still to come): features, distance and the last transmittance
#endif
  F g0[NR], g1[NR], g2[NR], gd[NR];
#if ERRORS
  F error[NR];
#endif
#if RAY_GRADIENTS
  F ray_gradient[NR][3 + 3 * ORIGINS];
#endif
  uint alive = 0;  // a bit per vector that still has a ray
  EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    const uint slot = base + VECTOR_SLOT(j, lid);
    load_ray(world_ray, ray_u, frame.slots, slot, &ray[j]);
#if ERRORS
    error[j] = LDV(ray_error + slot);
#endif
#if RAY_GRADIENTS
    for (int k = 0; k < 3 + 3 * ORIGINS; ++k) ray_gradient[j][k] = (F)R(0.0);
#endif
    g0[j] = LDV(grad_out + slot);
    g1[j] = LDV(grad_out + frame.slots + slot);
    g2[j] = LDV(grad_out + 2 * frame.slots + slot);
    gd[j] = LDV(grad_out + SIM_O_DISTANCE * frame.slots + slot);
#if RAY_ORDER
    to[j] = replayed_to[(tile * LS + lid) * NR + j];
    all_to = max(all_to, to[j]);
    alive |= (to[j] > 0 ? 1u : 0u) << j;
#else
    transmittance[j] = (F)R(1.0);
    behind[j] = behind_of(out + slot, grad_out + slot, frame.slots);
    alive |= (ANY(is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2])) ? 1u : 0u) << j;
#endif
  }

  const uint end = first[tile + 1];
  uint i = begin;
#if LS > 1
  __local real reduced[LS * (SIM_GRAD + 1)];
  __local int group_alive;
  for (; i < end; ++i) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (lid == 0) group_alive = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
#if RAY_ORDER
    if (i - begin >= all_to) alive = 0;
#endif
    if (alive) group_alive = 1;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (!group_alive) break;
#else
#if RAY_ORDER
  for (; i - begin < all_to; ++i) {
#else
  for (; i < end && alive; ++i) {
#endif
    fetch_ahead(payload, i, end, records, footprints, slot_first, grads, tx, ty);
#endif
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
    EACH_VECTOR
    for (int j = J_FIRST(packed); j <= j_last; ++j) {
      if (J_OUTSIDE(j, lid, packed) || !(alive >> j & 1u)) continue;
#if LS > 1
      RayLanes followed = ray[j];  // a value: in registers
      const RayLanes* seen = &followed;
#else
      const RayLanes* seen = &ray[j];  // copies make a CPU's backward pass 1.4 times as slow
#if ACTOR_MOTION
      RayLanes followed;
#endif
#endif
#if ACTOR_MOTION
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
      const F alpha = SEL(inside, VMIN(raw_alpha(record, response.q, log_cut), (F)ALPHA_MAX), (F)R(0.0));
      const F weight = alpha * transmittance[j];
      const F left = transmittance[j] - weight;
#endif
      const F tau = SEL(inside, response.tau, (F)R(0.0));
      const F inv_n = SEL(inside, response.inv_n, (F)R(0.0));
      const F q = SEL(inside, response.q, (F)R(0.0));
#if ERRORS
      blended_error = fma(weight, error[j], blended_error);
#endif
      sum[SIM_G_FEATURE] = fma(weight, g0[j], sum[SIM_G_FEATURE]);
      sum[SIM_G_FEATURE + 1] = fma(weight, g1[j], sum[SIM_G_FEATURE + 1]);
      sum[SIM_G_FEATURE + 2] = fma(weight, g2[j], sum[SIM_G_FEATURE + 2]);

#if !RAY_ORDER
      F value = g0[j] * record[SIM_R_FEATURE];
      value = fma(g1[j], (F)record[SIM_R_FEATURE + 1], value);
      value = fma(g2[j], (F)record[SIM_R_FEATURE + 2], value);
      value = fma(gd[j], tau, value);
      // None through the clamp, but tau keeps its own.
      const F d_log = log_alpha_gradient(inside, alpha, weight, transmittance[j], value, &behind[j]);
#endif
      sum[SIM_G_OPACITY] += d_log;
      const F dq = d_log * R(-0.5);
      const F dtau = weight * gd[j];

      // q = r^2 |o x a|^2 / |a|^2, tau = -(o . a) / |a|^2 with o = (0, 0, -1) + A delta.
      const F two_q = R(2.0) * dq;
      const F radial = two_q * record[SIM_R_RADIUS2];
      const F scale_q = radial * inv_n;
      const F along_a = (two_q * q + R(2.0) * dtau * tau) * inv_n;
      F da[3], origin[3];
#if ORIGINS
      const F o2 = fma(response.o[0], response.o[0],
                       fma(response.o[1], response.o[1], response.o[2] * response.o[2]));
      for (int k = 0; k < 3; ++k) {
        const F a = SEL(inside, response.a[k], (F)R(0.0));
        const F o = response.o[k];
        // d|o x a|^2/da = 2 (o^2 a - (o.a) o), d|o x a|^2/do = 2 (n o - (o.a) a), and -(o.a) = n tau.
        da[k] = fma(fma(scale_q, o2, -along_a), a, (radial * tau - dtau * inv_n) * o);
        origin[k] = fma(radial, fma(tau, a, o), -(dtau * inv_n * a));
      }
#else
      const F a0 = SEL(inside, response.a[0], (F)R(0.0));
      const F a1 = SEL(inside, response.a[1], (F)R(0.0));
      const F a2 = SEL(inside, response.a[2], (F)R(0.0));
      da[0] = fma(scale_q, a0, -(along_a * a0));
      da[1] = fma(scale_q, a1, -(along_a * a1));
      da[2] = fma(dtau, inv_n, -(along_a * a2));
      // do: 2 r^2 (a2 a0, a2 a1, -(a0^2 + a1^2)) / n - a dtau / n.
      const F s2 = scale_q * a2 - dtau * inv_n;
      origin[0] = s2 * a0;
      origin[1] = s2 * a1;
      origin[2] = -(scale_q * fma(a0, a0, a1 * a1)) - dtau * inv_n * a2;
#endif
      for (int k = 0; k < 3; ++k) {
        for (int c = 0; c < 3; ++c) {
          sum[SIM_G_MATRIX + 3 * k + c] = fma(da[k], seen->d[c], sum[SIM_G_MATRIX + 3 * k + c]);
#if ORIGINS
          sum[SIM_G_MATRIX + 3 * k + c] = fma(origin[k], seen->o[c], sum[SIM_G_MATRIX + 3 * k + c]);
#endif
        }
        sum[SIM_G_ORIGIN + k] += origin[k];
      }

#if RAY_GRADIENTS
      add_transposed(record, da, ray_gradient[j]);
#if ORIGINS
      add_transposed(record, origin, ray_gradient[j] + 3);
#endif
#endif

#if !RAY_ORDER
      transmittance[j] = left;
      const I done = AND(left < t_cut, inside);
      if (ANY(done)) {
        for (int k = 0; k < 3; ++k) ray[j].d[k] = SEL(done, (F)R(0.0), ray[j].d[k]);
        const I going = is_ray(ray[j].d[0], ray[j].d[1], ray[j].d[2]);
        if (!ANY(going)) alive &= ~(1u << j);
      }
#endif
    }

    const ulong slot = gradient_slot(footprints, slot_first, particle, tx, ty);
    __global real* target = grads + SIM_GRAD * slot;
#if LS > 1
    for (int k = 0; k < SIM_GRAD; ++k) reduced[lid * (SIM_GRAD + 1) + k] = HSUM(sum[k]);
    reduced[lid * (SIM_GRAD + 1) + SIM_GRAD] = HSUM(blended_error);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int k = (int)lid; k < SIM_GRAD + ERRORS; k += LS) {
      real total = R(0.0);
      for (int w = 0; w < LS; ++w) total += reduced[w * (SIM_GRAD + 1) + k];
      if (k < SIM_GRAD) target[k] = total;
      else instance_error[slot] = total;
    }
#else
#if V == 16
    vstore16(hsum16_each(sum), 0, target);
#else
    for (int k = 0; k < SIM_GRAD; ++k) target[k] = HSUM(sum[k]);
#endif
    if (ERRORS) instance_error[slot] = HSUM(blended_error);
#endif
  }
#if RAY_GRADIENTS
  EACH_VECTOR
  for (int j = 0; j < NR; ++j) {
    for (int k = 0; k < 3 + 3 * ORIGINS; ++k) {
      STV(ray_grads + k * frame.slots + base + VECTOR_SLOT(j, lid), ray_gradient[j][k]);
    }
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
