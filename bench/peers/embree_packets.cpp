// Traces rays through the boxes of embree_tracer.cpp.
#include <algorithm>
#include <cmath>

#include "bench/peers/embree_state.hpp"

namespace simuli::bench {

using namespace embree;

namespace {

constexpr std::size_t kPacketsAtOnce = 32;
constexpr float kAlphaMax = 0.999F;

/// Rays of a packet in the world, and the nearest responses of a round in ascending order.
struct Packet {
  RTCIntersectContext context;  // first member: callbacks receive its address
  bool origins = false;
  F o[3], d[3];  // o from o_ref, m
  F near, far;   // only responses between them are accepted
  int filled = 0;
  F tau[kWindow], q[kWindow], particle[kWindow];

  /// Inserts a response; lanes with kNowhere insert none. A full window loses its farthest entry.
  void insert(F at, F distance2, F index) {
    int k = std::min(filled, kWindow - 1);
    if (filled < kWindow) tau[filled++] = kNowhere;
    for (; k > 0; --k) {
      const M behind = at < tau[k - 1];  // this entry moves back
      put(at < tau[k], k, at, distance2, index);
      if (none_of(behind)) return;
      put(behind, k, tau[k - 1], q[k - 1], particle[k - 1]);
    }
    put(at < tau[0], 0, at, distance2, index);
  }

 private:
  void put(M here, int k, F at, F distance2, F index) {
    where(here, tau[k]) = at;
    where(here, q[k]) = distance2;
    where(here, particle[k]) = index;
  }
};

F exp_lanes(const F& x) {
  float values[W];
  store(x, values);
  for (float& value : values) value = std::exp(value);
  return load(values);
}

/// Computes the world direction of v at time t: the rotation so far, then the pose at the start.
void to_world(const Constants& c, bool moving, const F* v, F t, F* out) {
  F turned[3] = {v[0], v[1], v[2]};
  const float* m = moving ? c.rotation_start : c.rotation_ref;  // sensor_from_scene
  if (moving) {
    const float* axis = c.turn_axis;
    F sine, cosine;
    for (std::size_t lane = 0; lane < W; ++lane) {
      sine[lane] = std::sin(c.turn_angle * static_cast<float>(t[lane]));
      cosine[lane] = std::cos(c.turn_angle * static_cast<float>(t[lane]));
    }
    const F along = (axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]) * (1.0F - cosine);
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      turned[k] = v[k] * cosine + (axis[i] * v[j] - axis[j] * v[i]) * sine + axis[k] * along;
    }
  }
  for (int k = 0; k < 3; ++k) out[k] = m[k] * turned[0] + m[3 + k] * turned[1] + m[6 + k] * turned[2];
}

}  // namespace

/// Computes the response of one particle on the rays of a packet that reach its box.
void EmbreeTracer::State::intersect(const RTCIntersectFunctionNArguments* args) {
  auto& packet = *reinterpret_cast<Packet*>(args->context);
  const Particle& p = static_cast<const State*>(args->geometryUserPtr)->particles[args->primID];
  F a[3], o[3] = {p.origin[0], p.origin[1], p.origin[2]};
  for (int i = 0; i < 3; ++i) {
    a[i] = packet.d[0] * p.m[3 * i] + packet.d[1] * p.m[3 * i + 1] + packet.d[2] * p.m[3 * i + 2];
    if (!packet.origins) continue;
    o[i] += packet.o[0] * p.m[3 * i] + packet.o[1] * p.m[3 * i + 1] + packet.o[2] * p.m[3 * i + 2];
  }
  const F inv_n = 1.0F / (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  const F tau = -(o[0] * a[0] + o[1] * a[1] + o[2] * a[2]) * inv_n;
  const F cx = o[1] * a[2] - o[2] * a[1], cy = o[2] * a[0] - o[0] * a[2], cz = o[0] * a[1] - o[1] * a[0];
  const F q = (cx * cx + cy * cy + cz * cz) * inv_n;
  const F valid = stdx::static_simd_cast<F>(I(args->valid, stdx::element_aligned));
  const M met = q <= p.q_max && tau > packet.near && tau < packet.far && valid != 0.0F;
  if (none_of(met)) return;
  F at = kNowhere;
  where(met, at) = tau;
  packet.insert(at, q, static_cast<float>(args->primID));
  if (packet.filled < kWindow) return;
  // Boxes behind the last entry of a full window are skipped.
  packet.far = min(packet.far, packet.tau[kWindow - 1]);
  store(packet.far, &RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, 0));
}

void EmbreeTracer::State::trace_packet(const TracedRays& rays,
                                       std::size_t first,
                                       const Constants& c,
                                       bool moving,
                                       TracedResults& results) const {
  const float t_min = c.model.t_min, t_max = c.model.t_max, t_cut = c.transmittance_cut;
  const float log_cut = std::log(c.alpha_cut);
  Packet packet;
  rtcInitIntersectContext(&packet.context);
  packet.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  packet.origins = moving || !rays.origin[0].empty();
  const F time = rays.time.empty() ? F(0.5F) : load(rays.time.data() + first);
  F v[3];
  for (int k = 0; k < 3; ++k) v[k] = load(rays.direction[k].data() + first);
  M alive = v[0] != 0.0F || v[1] != 0.0F || v[2] != 0.0F;
  to_world(c, moving, v, time, packet.d);
  for (int k = 0; k < 3; ++k) packet.o[k] = 0.0F;
  if (!rays.origin[0].empty()) {
    for (int k = 0; k < 3; ++k) v[k] = load(rays.origin[k].data() + first);
    to_world(c, moving, v, time, packet.o);
  }

  alignas(64) RTCRayHit16 hits;
  alignas(64) int valid[W];
  for (int k = 0; k < 3; ++k) {
    if (moving) packet.o[k] += c.centre_step[k] * (time - 0.5F);
    store(packet.o[k] + c.centre_ref[k], hits.ray.org_x + k * W);
    store(packet.d[k], hits.ray.dir_x + k * W);
  }
  for (int lane = 0; lane < W; ++lane) {
    hits.ray.time[lane] = 0.0F;
    hits.ray.mask[lane] = ~0U;
    hits.ray.id[lane] = static_cast<unsigned>(lane);
    hits.ray.flags[lane] = 0;
    hits.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    hits.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }

  F left = 1.0F, distance = 0.0F, median = 0.0F, sum[3] = {0.0F, 0.0F, 0.0F};
  packet.near = t_min;
  while (any_of(alive)) {
    packet.far = t_max;
    packet.filled = 0;
    store(packet.near, hits.ray.tnear);
    store(packet.far, hits.ray.tfar);
    for (int lane = 0; lane < W; ++lane) valid[lane] = alive[lane] ? -1 : 0;
    rtcIntersect16(valid, scene, &packet.context, &hits);
    for (int k = 0; k < packet.filled; ++k) {
      const M met = alive && packet.tau[k] < kNowhere;
      if (none_of(met)) break;
      float q_max[W], features[3][W];
      for (std::size_t lane = 0; lane < W; ++lane) {
        const auto which = met[lane] ? static_cast<std::size_t>(packet.particle[k][lane]) : 0;
        q_max[lane] = particles[which].q_max;
        for (int i = 0; i < 3; ++i) features[i][lane] = particles[which].feature[i];
      }
      F alpha = 0.0F;
      where(met, alpha) = min(exp_lanes((load(q_max) - packet.q[k]) * 0.5F + log_cut), F(kAlphaMax));
      const F weight = alpha * left;
      F tau = 0.0F;
      where(met, tau) = packet.tau[k];
      for (int i = 0; i < 3; ++i) sum[i] += weight * load(features[i]);
      distance += weight * tau;
      const F next = left - weight;
      where(met && left > 0.5F && next <= 0.5F, median) = tau;
      left = next;
      alive = alive && !(met && left < t_cut);
    }
    // Rays whose window is not full have no further responses.
    if (packet.filled < kWindow) break;
    alive = alive && packet.tau[kWindow - 1] < kNowhere;
    packet.near = packet.tau[kWindow - 1];
  }

  for (int k = 0; k < 3; ++k) store(sum[k] + left * c.background[k], results.feature[k].data() + first);
  store(left, results.transmittance.data() + first);
  store(distance, results.distance.data() + first);
  store(median, results.median.data() + first);
}

void EmbreeTracer::trace(const TracedFrame& frame, const TracedRays& rays, TracedResults& results) const {
  const Constants c = in_float(frame.constants);
  const std::size_t count = rays.direction[0].size();
  for (std::vector<float>& feature : results.feature) feature.resize(count);
  for (std::vector<float>* out : {&results.transmittance, &results.distance, &results.median}) {
    out->resize(count);
  }
  in_parallel(count / W, kPacketsAtOnce, state_->threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      state_->trace_packet(rays, i * W, c, frame.moving, results);
    }
  });
}

}  // namespace simuli::bench
