#pragma once
// How close a frame's stages come to what the device can do: their arithmetic and memory traffic, and peaks
// of both measured beside them (Williams, Waterman, Patterson: Roofline, CACM 52(4), 2009).
#include <cstdint>
#include <map>
#include <string>

#include "host/device/render/scene/pass.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli::bench {

/// What kernels that do nothing else reach on all compute units, in float.
struct Peak {
  double gflop_s = 0.0;  // independent fused multiply-adds on registers, two operations each
  double gbyte_s = 0.0;  // a = b + s c over arrays that no cache holds
};

/// The best of several runs. Needs a device that was opened with profiling, and 384 MB of it.
[[nodiscard]] Peak measure_peak(const Device& device);

/// Vectors of rays that blending looks at for a particle, and those in which it changes a ray.
struct Visits {
  std::uint64_t looked = 0;
  std::uint64_t changed = 0;
};

/// Counted by going through the frame's lists again. Of a pass in order of range without actors in motion.
[[nodiscard]] Visits count_visits(const Pass& pass);

struct StageWork {
  double gflop = 0.0;
  double gbyte = 0.0;
};

/// What the stages of a frame and of its backward pass do at least: each value that a stage takes or leaves
/// moves once between it and memory, however often it is used; arithmetic in all lanes of a vector. Stages
/// that only move integers have no arithmetic.
[[nodiscard]] std::map<std::string, StageWork> stage_work(const Pass& pass);

}  // namespace simuli::bench
