#pragma once
#include <span>

#include "host/core/sensors/camera.hpp"
#include "host/device/render/options/options.hpp"
#include "host/device/runtime/device.hpp"

namespace simuli {

/// Error{kUsage} naming the option, what was found and what is allowed. Renderers ask for it; programs ask
/// earlier, before they read what is to be rendered.
void validate(const RenderOptions& options);

/// Colours and what multiplies them, on their way to the device: products of the largest still fit a float.
inline constexpr float kLargestColor = 1e20F;
inline constexpr float kLargestGain = 1e10F;
/// Error{kNumeric} naming `what` and the first value that is no number of at most `largest`.
void need_numbers(std::span<const float> values, float largest, const char* what);

}  // namespace simuli
