#pragma once
#include <array>
#include <vector>

#include "host/core/scene/appearance.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {

/// An environment of width x width / 2 texels: each the mean of the patches that point into it; those that
/// none points into take the mean around them, over the nearest square of texels that has any, of squares up
/// to 5.6 degrees wide; where that has none, either, the mean at their elevation, or at the nearest elevation
/// that has one. Grey without a patch.
/// `width` is even.
[[nodiscard]] EnvironmentMap environment_of(const std::vector<FarShell::Patch>& patches, int width);
/// The mean colour of the upper half of the patches: what a set lets through is the sky, as far as is known.
/// There must be one.
[[nodiscard]] std::array<float, 3> sky_colour(const std::vector<FarShell::Patch>& patches);

}  // namespace simuli
