#pragma once
#include "host/render/options/options.hpp"
#include "host/runtime/device.hpp"

namespace simuli {

/// As suits the device. CPUs: one work-item per tile, explicit vectors. GPUs: 64 scalar work-items of 4 rays.
[[nodiscard]] LaneShape lane_shape_of(const Device& device, Precision precision);

}  // namespace simuli
