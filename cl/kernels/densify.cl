// densify.cl - error-driven relocation and growth of a particle set. Launcher: host/device/render/train/densify.cpp
// METHOD section 11, after Kheradmand et al., "3D Gaussian splatting as Markov chain Monte Carlo" (2024), with
// sources drawn by reconstruction error instead of opacity.
#include "math/elementary.h"
#include "math/random.h"

#define SIM_DEAD_SIGMA R(0.005)
#define SIM_MAX_COPIES 51u  // upper limit of the opacity and scale correction

FN real sigma_of(real logit) { return R(1.0) / (R(1.0) + exp(-logit)); }

/// Error of each pixel: mean absolute difference of its channels, 0 where the ground truth is unknown (below
/// 0).
/// in  picture[3][slots], truth[3][slots]; world_ray: a zero direction marks slots without a pixel
__kernel void pixel_error(const uint slots,
                          __global const real* world_ray,
                          __global const real* picture,
                          __global const real* truth,
                          __global real* error) {
  const uint i = get_global_id(0);
  if (i >= slots) return;
  const int known =
      (world_ray[i] != R(0.0) || world_ray[slots + i] != R(0.0) || world_ray[2 * slots + i] != R(0.0)) &&
      truth[i] >= R(0.0);
  real sum = R(0.0);
  SIM_EACH(c, 3) sum += fabs(picture[c * slots + i] - truth[c * slots + i]);
  error[i] = known && sum < R(1e30) ? sum * R(0.333333333333333333) : R(0.0);
}

/// Error of each LiDAR ray, weighted as in the loss: distance (at most 1 m), intensity, and the probability
/// assigned to the wrong decision between hit and drop.
/// in  weight[3]; out[7][slots] of render; truth[2][slots]: range (0: no return, below 0: unknown), intensity;
///     world_ray
__kernel void beam_error(const uint slots,
                         __global const real* weight,
                         __global const real* world_ray,
                         __global const real* out,
                         __global const real* truth,
                         __global real* error) {
  const uint i = get_global_id(0);
  if (i >= slots) return;
  const real range = truth[i];
  const int fired =
      (world_ray[i] != R(0.0) || world_ray[slots + i] != R(0.0) || world_ray[2 * slots + i] != R(0.0)) &&
      range >= R(0.0);
  const int returned = range > R(0.0);
  const real drop = sigma_of(out[SIM_O_DROP * slots + i]);
  real sum = weight[2] * (returned ? drop : R(1.0) - drop);
  if (returned) {
    const real opacity = R(1.0) - out[SIM_O_TRANSMITTANCE * slots + i];
    const real off = fabs(out[SIM_O_DISTANCE * slots + i] / opacity - range);
    sum += weight[0] * (off < R(1.0) ? off : R(1.0));  // without opacity the distance is NaN and counts as 1
    sum += weight[1] * fabs(out[i] - truth[slots + i]);
  }
  error[i] = fired && sum < R(1e30) ? sum : R(0.0);
}

/// Adds the errors of a particle's pairs, weighted by blending in render_bwd, in the order of its slots.
__kernel void accumulate_error(const uint n,
                               __global const uint* keys,
                               __global const Footprint* footprints,
                               __global const uint* slot_first,
                               __global const real* pair_error,
                               __global real* accumulated) {
  const uint i = get_global_id(0);
  if (i >= n || keys[i] == 0xffffffffu) return;
  const uint count = SIM_TILES(footprints[i]);
  const __global real* slot = pair_error + slot_first[i];
  real sum = accumulated[i];
  for (uint k = 0; k < count; ++k) sum += slot[k];
  accumulated[i] = sum;
}

/// Returns a particle's weight in the draw; negative for a dead particle: nearly transparent, or with a
/// non-finite parameter.
FN real live_error(__global const real* params, uint stride, uint rows, uint i, real accumulated) {
  int sound = sigma_of(params[SIM_OPACITY * stride + i]) >= SIM_DEAD_SIGMA;
  for (uint row = 0; row < rows; ++row) sound = sound && fabs(params[row * stride + i]) < R(1e30);
  if (!sound) return R(-1.0);
  return accumulated > R(0.0) && accumulated < R(1e30) ? accumulated : R(0.0);
}

/// Counts dead particles and sums errors by chunk.
/// out dead[chunks]: dead particles; sums[chunks]: errors of live particles
__kernel void weigh_particles(const uint n,
                              const uint chunk,
                              const uint rows,
                              const uint stride,
                              __global const real* params,
                              __global const real* accumulated,
                              __global uint* dead,
                              __global real* sums) {
  const uint begin = get_global_id(0) * chunk;
  const uint end = min(begin + chunk, n);
  uint count = 0;
  real sum = R(0.0);
  for (uint i = begin; i < end; ++i) {
    const real error = live_error(params, stride, rows, i, accumulated[i]);
    count += error < R(0.0);
    sum += error > R(0.0) ? error : R(0.0);
  }
  dead[get_global_id(0)] = count;
  sums[get_global_id(0)] = sum;
}

/// Lists dead particles and quantises the draw's weights.
/// in  dead_before[chunks]: exclusive prefix sum; scale: makes the weights sum to less than 2^32
/// out targets[dead]: the dead particles in order; share[n]: integer weights
__kernel void list_dead(const uint n,
                        const uint chunk,
                        const uint rows,
                        const uint stride,
                        __global const real* params,
                        __global const real* accumulated,
                        __global const uint* dead_before,
                        const real scale,
                        __global uint* targets,
                        __global uint* share) {
  const uint begin = get_global_id(0) * chunk;
  const uint end = min(begin + chunk, n);
  uint place = dead_before[get_global_id(0)];
  for (uint i = begin; i < end; ++i) {
    const real error = live_error(params, stride, rows, i, accumulated[i]);
    if (error < R(0.0)) targets[place++] = i;
    share[i] = error > R(0.0) ? (uint)(error * scale) : 0;
  }
}

/// Draws the source of each target with probability share / total, by bisection of the running sum.
/// in  running[n]: exclusive prefix sum of the shares, total > 0
///     targets[listed], followed by the new particles first_new, first_new + 1, ...
/// out source[count]; copies[n], zero before: number of draws of each particle (integers, so the order does not
///     matter)
__kernel void draw_sources(const uint count,
                           const uint listed,
                           const uint first_new,
                           const uint n,
                           const uint total,
                           const uint seed_low,
                           const uint seed_high,
                           const uint iteration,
                           const uint set,
                           __global const uint* running,
                           __global uint* targets,
                           __global uint* source,
                           __global uint* copies) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  if (i >= listed) targets[i] = first_new + i - listed;
  const Random4 random = philox(seed_low, seed_high, targets[i], iteration, RANDOM_SOURCE, set);
  const uint place = mul_hi(random.word[0], total);  // in [0, total)
  uint low = 0, high = n - 1;                        // largest index whose running sum is at most `place`
  while (low < high) {
    const uint middle = low + (high - low + 1) / 2;
    if (running[middle] <= place)
      low = middle;
    else
      high = middle - 1;
  }
  source[i] = low;
  atomic_inc(copies + low);
}

/// Opacity and scale factor of `count` coincident particles that together look like one of opacity sigma: equal
/// transmittance at the centre and equal integral across (equation 9 of the paper; the hockey-stick identity
/// reduces its double sum to a single one).
FN void share_out(real sigma, uint count, real* each, real* scale) {
  const real copies = (real)min(count, SIM_MAX_COPIES);
  *each = R(1.0) - exp(log(R(1.0) - sigma) / copies);
  real sum = R(0.0), term = R(-1.0);
  for (real k = R(1.0); k <= copies; k += R(1.0)) {
    term *= -*each * (copies - k + R(1.0)) / k;
    sum += term / sqrt(k);
  }
  *scale = sigma / sum;
}

/// Copies the sources' parameters, with shared opacity and scale, to the targets. A second launch, whose
/// targets are the sources, updates the sources.
/// in  copies[n] of draw_sources; a source's copies are looked up in `source` (second launch: none)
__kernel void copy_particles(const uint count,
                             const uint rows,
                             const uint stride,
                             const uint in_place,
                             __global const uint* targets,
                             __global const uint* source,
                             __global const uint* copies,
                             __global real* params) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  const uint from = in_place ? i : source[i];
  const uint to = in_place ? i : targets[i];
  const uint drawn = copies[from];
  if (drawn == 0) return;
  const real sigma = sigma_of(params[SIM_OPACITY * stride + from]);
  real each, scale;
  share_out(sigma < R(0.9999) ? sigma : R(0.9999), drawn + 1, &each, &scale);
  each = each > SIM_DEAD_SIGMA ? each : SIM_DEAD_SIGMA;
  for (uint row = 0; row < rows; ++row) {
    real value = params[row * stride + from];
    if (row == SIM_OPACITY) value = log(each / (R(1.0) - each));
    if (row >= SIM_LOG_SCALE && row < SIM_ROTATION) value += log(scale);
    params[row * stride + to] = value;
  }
}

/// Zeroes the optimiser moments of the targets and of all sources.
__kernel void clear_moments(const uint count,
                            const uint n,
                            const uint rows,
                            const uint stride,
                            __global const uint* targets,
                            __global const uint* copies,
                            __global real* moments) {
  const uint i = get_global_id(0);
  if (i < count) {
    for (uint row = 0; row < rows; ++row) moments[row * stride + targets[i]] = R(0.0);
  }
  if (i < n && copies[i] > 0) {
    for (uint row = 0; row < rows; ++row) moments[row * stride + i] = R(0.0);
  }
}

/// Copies the `width` words of each source to its targets (words[n][width], for anchors).
__kernel void copy_words(const uint count,
                         const uint width,
                         __global const uint* targets,
                         __global const uint* source,
                         __global uint* words) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  for (uint k = 0; k < width; ++k) words[(ulong)targets[i] * width + k] = words[(ulong)source[i] * width + k];
}

/// Copies rows of length `stride` to rows of length new_stride; new columns are padding (as in
/// ParticleBuffers::upload) or 0.
__kernel void widen_rows(const uint rows,
                         const uint n,
                         const uint stride,
                         const uint new_stride,
                         const uint is_params,
                         __global const real* from,
                         __global real* to) {
  const uint i = get_global_id(0);
  if (i >= new_stride) return;
  for (uint row = 0; row < rows; ++row) {
    real value = R(0.0);
    if (is_params && row == SIM_ROTATION) value = R(1.0);
    if (is_params && row == SIM_OPACITY) value = R(-80.0);
    if (i < n) value = from[row * stride + i];
    to[row * new_stride + i] = value;
  }
}

/// Adds noise to the means of nearly transparent particles: strength x gate(sigma) x covariance x normal
/// numbers, with gate = logistic(100 (0.005 - sigma)) and strength in 1/m (noise times learning rate).
/// in  keys[n]: culled particles do not move
__kernel void jitter_means(const uint n,
                           const uint stride,
                           const real strength,
                           const uint seed_low,
                           const uint seed_high,
                           const uint iteration,
                           const uint set,
                           __global const uint* keys,
                           __global real* params) {
  const uint i = get_global_id(0);
  if (i >= n || keys[i] == 0xffffffffu) return;
  const real sigma = sigma_of(params[SIM_OPACITY * stride + i]);
  const real gate = sigma_of(R(100.0) * (SIM_DEAD_SIGMA - sigma));
  if (!(gate > R(1e-6))) return;
  real normal[3], along[3], q[4], length2 = R(0.0);
  normals_of(philox(seed_low, seed_high, i, iteration, RANDOM_NOISE, set), normal);
  SIM_EACH(k, 4) {
    q[k] = params[(SIM_ROTATION + k) * stride + i];
    length2 += q[k] * q[k];
  }
  if (!(length2 > R(0.0))) return;
  SIM_EACH(k, 4) q[k] /= sqrt(length2);
  const real w = q[0], x = q[1], y = q[2], z = q[3];
  const real rotation[9] = {R(1.0) - R(2.0) * (y * y + z * z),
                            R(2.0) * (x * y - w * z),
                            R(2.0) * (x * z + w * y),
                            R(2.0) * (x * y + w * z),
                            R(1.0) - R(2.0) * (x * x + z * z),
                            R(2.0) * (y * z - w * x),
                            R(2.0) * (x * z - w * y),
                            R(2.0) * (y * z + w * x),
                            R(1.0) - R(2.0) * (x * x + y * y)};
  SIM_EACH(k, 3) {
    const real s = exp(params[(SIM_LOG_SCALE + k) * stride + i]);
    along[k] = s * s * (rotation[k] * normal[0] + rotation[3 + k] * normal[1] + rotation[6 + k] * normal[2]);
  }
  SIM_EACH(c, 3) {
    const real step =
        rotation[3 * c] * along[0] + rotation[3 * c + 1] * along[1] + rotation[3 * c + 2] * along[2];
    const real moved = fma(strength * gate, step, params[(SIM_MEAN + c) * stride + i]);
    if (fabs(moved) < R(1e30)) params[(SIM_MEAN + c) * stride + i] = moved;
  }
}
