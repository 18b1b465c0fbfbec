#include "optim/poses/sensor_offsets.hpp"

#include <tuple>

namespace simuli {

PoseTangent SensorOffset::tangent() const {
  return {{value[0], value[1], value[2]}, {value[3], value[4], value[5]}};
}

void SensorOffset::step(const PoseGradient& gradient, double translation_rate_m, double rotation_rate_rad) {
  const Eigen::Vector3d &t = gradient.translation, &r = gradient.rotation;
  const double m = translation_rate_m, rad = rotation_rate_rad;
  SmallAdam::step({t.x(), t.y(), t.z(), r.x(), r.y(), r.z()}, {m, m, m, rad, rad, rad});
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

Pose moved_by(const SensorOffsets& offsets, const std::string& sensor, const Pose& rig_from_sensor) {
  const auto offset = offsets.find(sensor);
  return offset == offsets.end() ? rig_from_sensor : moved_by(offset->second, rig_from_sensor);
}

}  // namespace simuli
