#pragma once
#include "host/core/base/precision.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// The camera itself; Error{kDevice} with the numbers, before any memory is taken, where the device has no
/// room for the rays of its pixels.
[[nodiscard]] const Camera& with_room_on(const Device& device, const Camera& camera, Precision precision);

}  // namespace simuli
