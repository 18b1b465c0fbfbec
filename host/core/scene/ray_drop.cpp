#include "host/core/scene/ray_drop.hpp"

#include <algorithm>
#include <cmath>

#include "cl/shared/sensor_constants.h"

namespace simuli {
namespace {

static_assert(RayDrop::kParameters == shared::kReals<shared::DropConstants>);

}  // namespace

RayDrop::Parameters RayDrop::of_logits() {
  shared::DropConstants<double> function{};
  function.skip[0] = 1.0;
  return shared::reals_of(function);
}

RayDrop::Parameters RayDrop::start() {
  auto function = shared::from_reals<shared::DropConstants>(of_logits());
  // Evenly distributed numbers in [-2, 2] by the golden ratio: all sums differ, equal on all machines.
  constexpr double kGolden = 0.6180339887498949;
  double place = 0.5;
  for (double& weight : function.hidden) {
    place = std::fmod(place + kGolden, 1.0);
    weight = 4.0 * place - 2.0;
  }
  return shared::reals_of(function);
}

RayDrop::Parameters ray_drop_of(const std::vector<RayDrop>& all, const std::string& lidar) {
  if (all.empty()) return RayDrop::of_logits();
  const auto found = std::find_if(all.begin(), all.end(), [&](const RayDrop& d) { return d.lidar == lidar; });
  return found == all.end() ? all.front().parameters : found->parameters;
}

}  // namespace simuli
