#pragma once
// Roofline model: arithmetic and memory traffic of a frame's stages relative to measured peaks of the device
// (Williams, Waterman, Patterson: Roofline, CACM 52(4), 2009).
#include <cstdint>
#include <map>
#include <string>

#include "host/device/render/scene/pass.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli::bench {

/// Peaks of dedicated float kernels on all compute units.
struct Peak {
  double gflop_s = 0.0;  // independent fused multiply-adds in registers, two operations each
  double gbyte_s = 0.0;  // a = b + s c over arrays larger than all caches
};

/// Returns the best of several runs. Needs a device opened with profiling and 384 MB of its memory.
[[nodiscard]] Peak measure_peak(const Device& device);

/// Ray vectors that blending tests per particle, and vectors in which a ray changes.
struct Visits {
  std::uint64_t looked = 0;
  std::uint64_t changed = 0;
};

/// Counts visits by processing the lists of the frame again. Needs a pass in order of range without moving
/// actors.
[[nodiscard]] Visits count_visits(const Pass& pass);

struct StageWork {
  double gflop = 0.0;
  double gbyte = 0.0;
};

/// Returns the minimum work of the stages of a frame and its backward pass: each input and output value of a
/// stage is transferred once; arithmetic counts all lanes of a vector. Stages that only move integers have no
/// arithmetic.
[[nodiscard]] std::map<std::string, StageWork> stage_work(const Pass& pass);

}  // namespace simuli::bench
