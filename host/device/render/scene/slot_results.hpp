#pragma once
#include <array>
#include <span>

#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/render/scene/ray_results.hpp"

namespace simuli {

/// Converts from slot order. outputs: [SIM_OUTPUTS][slots], cameras without the last row; picture: [3][slots],
/// replaces the features unless empty. Pixels without a ray get `background`.
[[nodiscard]] RayResults results_of(const RayGrid& grid,
                                    std::span<const float> outputs,
                                    std::span<const float> picture,
                                    const std::array<float, 3>& background,
                                    bool has_median);

}  // namespace simuli
