#include <cmath>
#include <cstdint>

#include "host/core/base/interruption.hpp"
#include "host/device/render/rays/ray_grid.hpp"
#include "host/device/render/scene/slot_results.hpp"

namespace simuli {

float RayResults::drop_probability(std::size_t ray) const {
  return 1.0F / (1.0F + std::exp(-drop_logit[ray]));
}

float RayResults::expected_distance(std::size_t ray) const {
  const float opacity = 1.0F - transmittance[ray];
  return opacity > 0.0F ? distance[ray] / opacity : 0.0F;
}

RayResults results_of(const RayGrid& grid,
                      std::span<const float> outputs,
                      std::span<const float> picture,
                      const std::array<float, 3>& background,
                      bool has_median) {
  const std::size_t slots = grid.frame.slots;
  RayResults results;
  results.rays = grid.rays;
  std::vector<float>* rows[SIM_OUTPUTS] = {&results.feature[0],
                                           &results.feature[1],
                                           &results.feature[2],
                                           &results.transmittance,
                                           &results.distance,
                                           &results.median,
                                           &results.drop_logit};
  for (std::size_t row = 0; row < SIM_OUTPUTS; ++row) {
    Interruption::ask();
    if (row == SIM_O_MEDIAN && !has_median) continue;
    if (row == SIM_O_DROP && grid.type != SensorType::kLidar) continue;
    const float empty = row < SIM_O_TRANSMITTANCE    ? background[row]
                        : row == SIM_O_TRANSMITTANCE ? 1.0F
                        : row == SIM_O_DROP          ? background[2] - background[1]
                                                     : 0.0F;
    rows[row]->assign(grid.rays, empty);
    const std::span<const float> shown = !picture.empty() && row < SIM_O_TRANSMITTANCE ? picture : outputs;
    for (std::size_t slot = 0; slot < slots; ++slot) {
      const std::int32_t ray = grid.ray_of_slot[slot];
      if (ray >= 0) (*rows[row])[static_cast<std::size_t>(ray)] = shown[row * slots + slot];
    }
  }
  return results;
}

}  // namespace simuli
