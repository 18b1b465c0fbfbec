// anchor.cl - nearest neighbours of one set in another, and their distance as a loss. Launcher: optim/train/paper/anchor_stage.cpp
// Points are sorted by Morton code (63 bits, 21 per axis), 16 per leaf and 16 leaves or nodes per node: a tree
// of bounding boxes without pointers that suits clusters, lines and outliers as well as even clouds. Node i of
// a level has the children 16 i .. 16 i + 15 of the level below; leaves are below level 0. Particles of actors
// are in their actor's frame, so neighbours belong to the same frame.
// Build: NEIGHBOURS, the K; LS, the work-items of a query: 1 with vectors of 16 or, on GPUs, 16 that share the
// heap and the pending nodes in local memory.
#include "math/lanes.h"
#include "shared/layout.h"

#define SIM_ANCHOR_WIDTH 16
#define SIM_ANCHOR_LEVELS 6  // 16^6 leaves exceed the largest set
#define SIM_ANCHOR_NONE 0xffffffffu
#define SIM_ANCHOR_FAR ((real)INFINITY)
typedef REAL_VECTOR(16) R16;

// The part of 16 lanes that one work-item has: all, or one.
#if LS > 1
#define SIM_ANCHOR_SHARED __local
#define SIM_ANCHOR_SYNC barrier(CLK_LOCAL_MEM_FENCE)
typedef real Part;
#define SIM_ANCHOR_PART(k, p) ((p)[(k)*SIM_ANCHOR_WIDTH + get_local_id(0)])
#define SIM_ANCHOR_KEEP(v, k, p) ((p)[(k)*SIM_ANCHOR_WIDTH + get_local_id(0)] = (v))
#else
#define SIM_ANCHOR_SHARED
#define SIM_ANCHOR_SYNC
typedef R16 Part;
#define SIM_ANCHOR_PART(k, p) vload16(k, p)
#define SIM_ANCHOR_KEEP(v, k, p) vstore16(v, k, p)
#endif

FN real min16(R16 v) {
  const REAL_VECTOR(8) a = VMIN(v.lo, v.hi);
  const REAL_VECTOR(4) b = VMIN(a.lo, a.hi);
  const REAL_VECTOR(2) c = VMIN(b.lo, b.hi);
  return VMIN(c.x, c.y);
}
FN real max16(R16 v) { return -min16(-v); }

FN int is_finite_point(real x, real y, real z) {
  return fabs(x) < SIM_ANCHOR_FAR && fabs(y) < SIM_ANCHOR_FAR && fabs(z) < SIM_ANCHOR_FAR;
}

/// Returns the frame of particle i (GaussianSet::actor); actor_of is unused without actors.
FN uint frame_of(uint actors, __global const uint* actor_of, uint i) { return actors > 0 ? actor_of[i] : 0; }

/// Bounds of the finite points of each chunk.
/// out boxes[work-items][6]: smallest x, y, z and largest x, y, z
__kernel void anchor_bounds(
    __global const real* params, const uint stride, const uint n, const uint chunk, __global real* boxes) {
  const uint begin = get_global_id(0) * chunk;
  const uint end = min(begin + chunk, n);
  real low[3], high[3];
  SIM_EACH(k, 3) low[k] = SIM_ANCHOR_FAR, high[k] = -SIM_ANCHOR_FAR;
  for (uint i = begin; i < end; ++i) {
    real p[3];
    SIM_EACH(k, 3) p[k] = params[(SIM_MEAN + k) * stride + i];
    if (!is_finite_point(p[0], p[1], p[2])) continue;
    SIM_EACH(k, 3) low[k] = VMIN(low[k], p[k]), high[k] = VMAX(high[k], p[k]);
  }
  __global real* box = boxes + 6 * get_global_id(0);
  SIM_EACH(k, 3) box[k] = low[k], box[3 + k] = high[k];
}

/// Spreads the bits of a 21-bit number to every third bit.
FN ulong spread_bits(ulong x) {
  x = (x | x << 32) & 0x001f00000000ffffUL;
  x = (x | x << 16) & 0x001f0000ff0000ffUL;
  x = (x | x << 8) & 0x100f00f00f00f00fUL;
  x = (x | x << 4) & 0x10c30c30c30c30c3UL;
  return (x | x << 2) & 0x1249249249249249UL;
}

/// Computes 32 bits of each point's Morton code; non-finite points sort last.
/// in  frame[4]: lowest corner, cells per m; order[n], unused in the first pass (shift 0)
/// out keys[n]: bits [shift, shift + 32) of the code of point order[i]; order[n] = i in the first pass
__kernel void anchor_keys(__global const real* params,
                          const uint stride,
                          const uint n,
                          __global const real* frame,
                          const uint shift,
                          __global uint* order,
                          __global uint* keys) {
  const uint i = get_global_id(0);
  if (i >= n) return;
  if (shift == 0) order[i] = i;
  const uint point = order[i];
  real p[3];
  SIM_EACH(k, 3) p[k] = params[(SIM_MEAN + k) * stride + point];
  ulong code = ~0UL;
  if (is_finite_point(p[0], p[1], p[2])) {
    code = 0;
    SIM_EACH(k, 3) {
      const real cell = (p[k] - frame[k]) * frame[3];
      const ulong clamped = cell > R(0.0) ? min((ulong)cell, (ulong)0x1fffff) : 0;
      code |= spread_bits(clamped) << k;
    }
  }
  keys[i] = (uint)(code >> shift);
}

/// Writes leaves, and their boxes as lanes of the nodes of level 0.
/// out points[leaves][3][16]; ids[leaves][16], SIM_ANCHOR_NONE for empty lanes; boxes[nodes][6][16]
__kernel void anchor_leaves(__global const real* params,
                            const uint stride,
                            const uint n,
                            __global const uint* order,
                            __global real* points,
                            __global uint* ids,
                            __global real* boxes,
                            const uint leaves) {
  const uint leaf = get_global_id(0);
  if (leaf >= leaves) return;
  real low[3], high[3];
  SIM_EACH(k, 3) low[k] = SIM_ANCHOR_FAR, high[k] = -SIM_ANCHOR_FAR;
  for (uint lane = 0; lane < SIM_ANCHOR_WIDTH; ++lane) {
    const uint i = leaf * SIM_ANCHOR_WIDTH + lane;
    uint id = SIM_ANCHOR_NONE;
    real p[3] = {SIM_ANCHOR_FAR, SIM_ANCHOR_FAR, SIM_ANCHOR_FAR};
    if (i < n) {
      const uint point = order[i];
      real q[3];
      SIM_EACH(k, 3) q[k] = params[(SIM_MEAN + k) * stride + point];
      if (is_finite_point(q[0], q[1], q[2])) {
        id = point;
        SIM_EACH(k, 3) p[k] = q[k], low[k] = VMIN(low[k], q[k]), high[k] = VMAX(high[k], q[k]);
      }
    }
    ids[i] = id;
    SIM_EACH(k, 3) points[(leaf * 3 + k) * (ulong)SIM_ANCHOR_WIDTH + lane] = p[k];
  }
  __global real* box =
      boxes + (ulong)(leaf / SIM_ANCHOR_WIDTH) * 6 * SIM_ANCHOR_WIDTH + leaf % SIM_ANCHOR_WIDTH;
  SIM_EACH(k, 3) box[k * SIM_ANCHOR_WIDTH] = low[k], box[(3 + k) * SIM_ANCHOR_WIDTH] = high[k];
}

/// Writes boxes of the nodes [child_first, child_first + children) as lanes of the level above, from
/// parent_first on. Lanes without a child, also in leaves, must contain NaN so that no query visits them.
__kernel void anchor_nodes(__global real* boxes,
                           const uint child_first,
                           const uint children,
                           const uint parent_first) {
  const uint child = get_global_id(0);
  if (child >= children) return;
  __global const real* from = boxes + (ulong)(child_first + child) * 6 * SIM_ANCHOR_WIDTH;
  __global real* to = boxes + (ulong)(parent_first + child / SIM_ANCHOR_WIDTH) * 6 * SIM_ANCHOR_WIDTH +
                      child % SIM_ANCHOR_WIDTH;
  SIM_EACH(k, 3) {
    const R16 low = vload16(k, from), high = vload16(3 + k, from);
    to[k * SIM_ANCHOR_WIDTH] = min16(SEL(low <= SIM_ANCHOR_FAR, low, (R16)SIM_ANCHOR_FAR));
    to[(3 + k) * SIM_ANCHOR_WIDTH] = max16(SEL(high >= -SIM_ANCHOR_FAR, high, (R16)(-SIM_ANCHOR_FAR)));
  }
}

/// Squared distances from p to 16 boxes; infinite for empty boxes (smallest above largest, or NaN). Rounds
/// monotonically like the distance to a point: never above the distance to a point inside the box.
FN Part box_distances(__global const real* box, const real* p) {
  Part sum = (Part)R(0.0);
  Part empty_low = SIM_ANCHOR_PART(0, box);
  SIM_EACH(k, 3) {
    const Part below = SIM_ANCHOR_PART(k, box) - p[k];
    const Part above = p[k] - SIM_ANCHOR_PART(3 + k, box);
    Part outside = SEL(below > above, below, above);
    outside = SEL(outside > R(0.0), outside, (Part)R(0.0));
    sum = sum + outside * outside;
  }
  return SEL(empty_low < SIM_ANCHOR_FAR, sum, (Part)SIM_ANCHOR_FAR);
}

/// Number of nodes in a level of the tree over n points.
FN uint nodes_of(uint n, int level) { return (n + (1u << (4 * level + 8)) - 1u) >> (4 * level + 8); }

/// Whether neighbour (d, id) comes after (e, other): by distance, then by index.
FN int comes_after(real d, uint id, real e, uint other) { return d > e || (d == e && id > other); }

/// Replaces the root of a heap of `count` entries, whose root is the farthest neighbour, by (d, id).
FN void sift_down(
    SIM_ANCHOR_SHARED real* distance, SIM_ANCHOR_SHARED uint* neighbour, uint count, real d, uint id) {
  uint at = 0;
  while (2 * at + 1 < count) {
    uint child = 2 * at + 1;
    if (child + 1 < count &&
        comes_after(distance[child + 1], neighbour[child + 1], distance[child], neighbour[child])) {
      ++child;
    }
    if (!comes_after(distance[child], neighbour[child], d, id)) break;
    distance[at] = distance[child];
    neighbour[at] = neighbour[child];
    at = child;
  }
  distance[at] = d;
  neighbour[at] = id;
}

/// Finds the K nearest candidates of each query. One query per group of LS work-items: depth first, nearest
/// child first, skipping boxes farther than the K-th neighbour.
/// in  queries: parameter rows, of which the means are read; boxes, points, ids of the tree over n points;
///     query_actor_of[N], actor_of[n] if query_actors, actors > 0
/// out candidates[N][K]: neighbours in the query's frame within reach, nearest first, ties by index;
///     SIM_ANCHOR_NONE where there are fewer
///     nearest[N]: the first candidate
__kernel SIM_GROUP void anchor_search(__global const real* queries,
                                      const uint query_stride,
                                      const uint query_count,
                                      const uint query_actors,
                                      __global const uint* query_actor_of,
                                      const uint n,
                                      const uint actors,
                                      __global const uint* actor_of,
                                      const real reach2,
                                      __global const real* boxes,
                                      __global const real* points,
                                      __global const uint* ids,
                                      __global uint* candidates,
                                      __global uint* nearest) {
  SIM_ANCHOR_SHARED real distance[NEIGHBOURS];
  SIM_ANCHOR_SHARED uint neighbour[NEIGHBOURS];
  // Squared distances of the unvisited children of the nodes on the current path.
  SIM_ANCHOR_SHARED real pending[SIM_ANCHOR_LEVELS * SIM_ANCHOR_WIDTH];
  SIM_ANCHOR_SHARED real found[SIM_ANCHOR_WIDTH];
  const uint query = get_global_id(0) / LS, lid = get_global_id(0) % LS;
  if (query >= query_count) return;
  real p[3];
  SIM_EACH(k, 3) p[k] = queries[(SIM_MEAN + k) * query_stride + query];
  const uint own_frame = frame_of(query_actors, query_actor_of, query);
  for (uint k = lid; k < NEIGHBOURS; k += LS) distance[k] = reach2, neighbour[k] = SIM_ANCHOR_NONE;

  int top = 0;
  uint first = 0;  // first node of the level
  while (nodes_of(n, top) > 1 && top + 1 < SIM_ANCHOR_LEVELS) first += nodes_of(n, top++);
  int level = top;
  uint node = 0;  // index within its level
  if (n > 0)
    SIM_ANCHOR_KEEP(box_distances(boxes + (ulong)first * 6 * SIM_ANCHOR_WIDTH, p), level, pending);
  else
    level = top + 1;
  SIM_ANCHOR_SYNC;
  while (level <= top) {
    const real least = min16(vload16(level, pending));
    if (!(least <= distance[0] && least < SIM_ANCHOR_FAR)) {
      first += nodes_of(n, level++);
      node /= SIM_ANCHOR_WIDTH;
      continue;
    }
    uint lane = 0;
    while (lane < SIM_ANCHOR_WIDTH - 1 && pending[level * SIM_ANCHOR_WIDTH + lane] != least) ++lane;
    SIM_ANCHOR_SYNC;
    if (lid == 0) pending[level * SIM_ANCHOR_WIDTH + lane] = SIM_ANCHOR_FAR;
    const uint child = node * SIM_ANCHOR_WIDTH + lane;
    if (level > 0) {
      first -= nodes_of(n, --level);
      node = child;
      SIM_ANCHOR_KEEP(
          box_distances(boxes + (ulong)(first + child) * 6 * SIM_ANCHOR_WIDTH, p), level, pending);
      SIM_ANCHOR_SYNC;
      continue;
    }
    const __global real* leaf = points + (ulong)child * 3 * SIM_ANCHOR_WIDTH;
    const Part dx = SIM_ANCHOR_PART(0, leaf) - p[0], dy = SIM_ANCHOR_PART(1, leaf) - p[1],
               dz = SIM_ANCHOR_PART(2, leaf) - p[2];
    SIM_ANCHOR_KEEP(dx * dx + dy * dy + dz * dz, 0, found);
    SIM_ANCHOR_SYNC;
    for (uint k = 0; lid == 0 && k < SIM_ANCHOR_WIDTH; ++k) {
      if (found[k] > distance[0]) continue;
      const uint id = ids[child * SIM_ANCHOR_WIDTH + k];
      if (id == SIM_ANCHOR_NONE || frame_of(actors, actor_of, id) != own_frame) continue;
      if (comes_after(distance[0], neighbour[0], found[k], id)) {
        sift_down(distance, neighbour, NEIGHBOURS, found[k], id);
      }
    }
    SIM_ANCHOR_SYNC;
  }
  SIM_ANCHOR_SYNC;  // other work-items may still read the root that is replaced now
  if (lid > 0) return;
  // The heap's root is the farthest, so the list is written from its end.
  __global uint* out = candidates + (ulong)query * NEIGHBOURS;
  for (uint left = NEIGHBOURS; left > 0; --left) {
    out[left - 1] = neighbour[0];
    sift_down(distance, neighbour, left - 1, distance[left - 1], neighbour[left - 1]);
  }
  nearest[query] = out[0];
}

/// Adds the anchoring loss: the distance of each visible particle to its nearest candidate. Only the particle
/// gets a gradient; it is 0 at the candidate itself and for a candidate that relocation has moved to another
/// frame.
/// in  keys[n]: 0xffffffff for a culled particle; candidates[n][K]; choose: whether to select the nearest
///     candidate again; actor_of, target_actor_of as in anchor_search
/// io  nearest[n]; grads[rows][stride]: weight times the unit vector away from the candidate is added to the
/// means' rows
/// out sums[work-items][2]: sum of distances in m, and their number
__kernel void anchor_loss(const uint n,
                          const uint chunk,
                          __global const uint* keys,
                          __global const real* params,
                          const uint stride,
                          const uint actors,
                          __global const uint* actor_of,
                          __global const real* targets,
                          const uint target_stride,
                          const uint target_actors,
                          __global const uint* target_actor_of,
                          __global const uint* candidates,
                          const uint choose,
                          const real weight,
                          __global uint* nearest,
                          __global real* grads,
                          __global real* sums) {
  const uint begin = get_global_id(0) * chunk;
  const uint end = min(begin + chunk, n);
  real sum = R(0.0), count = R(0.0);
  for (uint i = begin; i < end; ++i) {
    uint target = nearest[i];
    if (keys[i] == 0xffffffffu || target == SIM_ANCHOR_NONE) continue;
    const uint own_frame = frame_of(actors, actor_of, i);
    real p[3], away[3];
    SIM_EACH(k, 3) p[k] = params[(SIM_MEAN + k) * stride + i];
    if (choose) {
      real least = SIM_ANCHOR_FAR;
      __global const uint* list = candidates + (ulong)i * NEIGHBOURS;
      for (uint c = 0; c < NEIGHBOURS && list[c] != SIM_ANCHOR_NONE; ++c) {
        if (frame_of(target_actors, target_actor_of, list[c]) != own_frame) continue;
        real d2 = R(0.0);
        SIM_EACH(k, 3) {
          const real d = p[k] - targets[(SIM_MEAN + k) * target_stride + list[c]];
          d2 = fma(d, d, d2);
        }
        if (d2 < least) least = d2, target = list[c];
      }
      nearest[i] = target;
    }
    if (frame_of(target_actors, target_actor_of, target) != own_frame) continue;
    real d2 = R(0.0);
    SIM_EACH(k, 3) {
      away[k] = p[k] - targets[(SIM_MEAN + k) * target_stride + target];
      d2 = fma(away[k], away[k], d2);
    }
    if (!(d2 < SIM_ANCHOR_FAR)) continue;
    count += R(1.0);
    if (!(d2 > R(0.0))) continue;
    const real distance = sqrt(d2);
    sum += distance;
    SIM_EACH(k, 3) grads[(SIM_MEAN + k) * stride + i] += weight * away[k] / distance;
  }
  sums[2 * get_global_id(0)] = sum;
  sums[2 * get_global_id(0) + 1] = count;
}
