#pragma once
#include <array>
#include <span>

#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/render/scene/ray_results.hpp"

namespace simuli {

/// From slot order. outputs: [SIM_OUTPUTS][slots], of cameras without the last; picture: [3][slots], shown
/// instead of the outputs' features where it isn't empty. Pixels without a ray show `background`.
[[nodiscard]] RayResults results_of(const RayGrid& grid,
                                    std::span<const float> outputs,
                                    std::span<const float> picture,
                                    const std::array<float, 3>& background,
                                    bool has_median);

}  // namespace simuli
