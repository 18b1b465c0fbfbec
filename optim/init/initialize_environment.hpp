#pragma once
#include <array>
#include <vector>

#include "host/core/scene/appearance.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {

/// Returns an environment map of width x width / 2 texels. A texel is the mean of the patches in its direction;
/// without any the mean over the smallest surrounding square with patches, up to 5.6 degrees wide; otherwise
/// the mean at its elevation, or at the nearest elevation with patches. Grey without patches. `width` must be
/// even.
[[nodiscard]] EnvironmentMap environment_of(const std::vector<FarShell::Patch>& patches, int width);
/// Returns the mean colour of the patches in the upper half, the estimate of the sky's colour. Requires at
/// least one patch.
[[nodiscard]] std::array<float, 3> sky_colour(const std::vector<FarShell::Patch>& patches);

}  // namespace simuli
