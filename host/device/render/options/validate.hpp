#pragma once
#include <span>

#include "host/core/sensors/camera.hpp"
#include "host/device/render/options/options.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Throws Error{kUsage} with option, found and allowed value. Renderers call it; programs call it before
/// reading input.
void validate(const RenderOptions& options);

/// Upper bound of colours and their factors on the device: products of the largest values fit a float.
inline constexpr float kLargestColor = 1e20F;
inline constexpr float kLargestGain = 1e10F;
/// Throws Error{kNumeric} with `what` and the first value that is not finite or exceeds `largest`.
void need_numbers(std::span<const float> values, float largest, const char* what);

}  // namespace simuli
