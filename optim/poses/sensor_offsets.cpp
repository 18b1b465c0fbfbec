#include "optim/poses/sensor_offsets.hpp"

#include <cmath>
#include <tuple>

namespace simuli {

PoseTangent SensorOffset::tangent() const {
  return {{value[0], value[1], value[2]}, {value[3], value[4], value[5]}};
}

void SensorOffset::step(const PoseGradient& gradient, double translation_rate_m, double rotation_rate_rad) {
  constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-15;
  if (!gradient.translation.allFinite() || !gradient.rotation.allFinite()) return;
  ++steps;
  const auto t = static_cast<double>(steps);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto axis = static_cast<Eigen::Index>(i % 3);
    const double g = i < 3 ? gradient.translation(axis) : gradient.rotation(axis);
    first[i] = kBeta1 * first[i] + (1.0 - kBeta1) * g;
    second[i] = kBeta2 * second[i] + (1.0 - kBeta2) * g * g;
    const double m = first[i] / (1.0 - std::pow(kBeta1, t));
    const double v = second[i] / (1.0 - std::pow(kBeta2, t));
    value[i] -= (i < 3 ? translation_rate_m : rotation_rate_rad) * m / (std::sqrt(v) + kEpsilon);
  }
}

View moved_by(const SensorOffset& offset, const View& view) {
  View moved = view;
  std::tie(moved.scene_from_sensor_start, moved.scene_from_sensor_end) =
      moved_by(offset.tangent(), view.scene_from_sensor_start, view.scene_from_sensor_end);
  return moved;
}

Pose moved_by(const SensorOffset& offset, const Pose& rig_from_sensor) {
  return moved_by(offset.tangent(), rig_from_sensor, rig_from_sensor).first;
}

}  // namespace simuli
