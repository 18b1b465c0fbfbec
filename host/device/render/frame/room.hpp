#pragma once
#include "host/core/base/precision.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Returns the camera. Throws Error{kDevice} with the sizes, before any allocation, when the device lacks
/// memory for the rays of its pixels.
[[nodiscard]] const Camera& with_room_on(const Device& device, const Camera& camera, Precision precision);

}  // namespace simuli
