#pragma once
#include "host/device/render/options/options.hpp"
#include "host/device/runtime/build_options.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Returns the shape for a kind of device. CPUs: one work-item per tile with explicit vectors. GPUs: one scalar
/// work-item per ray (docs/DECISIONS.md, "GPUs").
[[nodiscard]] LaneShape lane_shape_of(const Device& device, Precision precision);

/// Returns definitions for kernels whose work-items process `lanes` values; 0: chosen for the device.
[[nodiscard]] BuildOptions lane_options(const Device& device, Precision precision, int lanes = 0);

}  // namespace simuli
