#pragma once
// Common parts of embree_tracer.cpp and embree_packets.cpp.
#include <cstddef>
#include <cstdint>
#include <embree3/rtcore.h>
#include <experimental/simd>
#include <functional>
#include <span>
#include <vector>

#include "bench/peers/embree_tracer.hpp"
#include "cl/shared/layout.h"
#include "cl/shared/sensor_constants.h"

namespace simuli::bench {
namespace embree {

namespace stdx = std::experimental;

inline constexpr int W = EmbreeTracer::kPacket;
inline constexpr int kWindow = 32;  // responses per round
inline constexpr float kNowhere = 1e30F;

using F = stdx::simd<float, stdx::simd_abi::deduce_t<float, W>>;
using M = F::mask_type;
using I = stdx::rebind_simd_t<std::int32_t, F>;

inline F load(const float* from) { return F(from, stdx::element_aligned); }
inline void store(const F& value, float* to) { value.copy_to(to, stdx::element_aligned); }

/// One cache line: o_g = M (o_ref - mu), M = diag(1/s^) R^T, largest squared distance with a response,
/// features.
struct alignas(64) Particle {
  float origin[3];
  float m[9];
  float q_max;
  float feature[3];
};
static_assert(sizeof(Particle) == 64);

/// Calls f(first, last) for parts of [0, count) in `threads` threads.
void in_parallel(std::size_t count,
                 std::size_t part,
                 int threads,
                 const std::function<void(std::size_t, std::size_t)>& f);

using Constants = shared::SensorConstants<float>;
[[nodiscard]] Constants in_float(const shared::SensorConstants<double>& constants);

}  // namespace embree

struct EmbreeTracer::State {
  int threads = 1;
  int sh_degree = 0, clamped_channels = 3;
  std::size_t count = 0, padded = 0;        // number of particles; rounded up to blocks of W
  std::vector<float> values;                // [rows][padded]
  std::vector<float> scale2;                // [3][padded] m^2
  std::vector<float> rotation;              // [9][padded] R, row-major
  std::vector<embree::Particle> particles;  // [padded]
  std::vector<float> half;                  // [3][padded] m, half extents of the boxes around the means
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  State() = default;
  ~State();
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  [[nodiscard]] const float* row(std::size_t r) const { return values.data() + r * padded; }
  void prepare_block(std::size_t i, const embree::Constants& constants);
  void bound_block(std::size_t i, const embree::Constants& constants);
  void new_scene();
  void trace_packet(const TracedRays& rays,
                    std::size_t first,
                    const embree::Constants& constants,
                    bool moving,
                    TracedResults& results) const;

  // Embree's callbacks.
  static void bounds(const RTCBoundsFunctionArguments* args);
  static void intersect(const RTCIntersectFunctionNArguments* args);
};

}  // namespace simuli::bench
