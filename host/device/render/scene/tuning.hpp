#pragma once
// What is fastest on a device, found by rendering: how work is spread over work-items.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/core/base/spread.hpp"
#include "host/device/runtime/device.hpp"
#include "host/device/runtime/tuning.hpp"

namespace simuli {

/// A camera's and a LiDAR's frame in one way of launching.
struct TuningTime {
  DeviceTuning tuning;
  Spread camera_ms, lidar_ms;
};

/// Every way that was tried, the usual one (0 throughout) first, and the one to keep: another than the usual
/// one only where the two frames take at least 2 % less time, in their geometric mean, and less by more than
/// what both times vary by.
struct TuningSearch {
  std::vector<TuningTime> times;
  std::size_t best = 0;
};

/// Times shapes of a tile, then sizes of groups with the best of them, each `frames` times in turns with the
/// others: 640 x 360 pixels and 64 x 2650 beams before that street. The device is used as before afterwards.
[[nodiscard]] TuningSearch time_tunings(const Device& device, std::int64_t particles, int frames);

}  // namespace simuli
