#pragma once
#include "host/device/render/options/options.hpp"
#include "host/device/runtime/build_options.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// As suits the kind of device. CPUs: one work-item per tile, explicit vectors. GPUs: a scalar work-item a ray, which
/// blends a camera on an NVIDIA H200 in 0.45 and a LiDAR in 0.57 of the time of 64 of 4 rays (bench/RESULTS.md).
[[nodiscard]] LaneShape lane_shape_of(const Device& device, Precision precision);

/// For kernels whose work-items take `lanes` values each; 0: as suits the device.
[[nodiscard]] BuildOptions lane_options(const Device& device, Precision precision, int lanes = 0);

}  // namespace simuli
