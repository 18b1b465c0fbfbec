#pragma once
// Offsets of sensors from where the log says they sit, learned by Adam.
#include <map>
#include <string>

#include "host/render/backward/pose_gradient.hpp"
#include "host/render/scene/renderer.hpp"
#include "optim/poses/small_adam.hpp"

namespace simuli {

/// One sensor's offset with its optimiser: a PoseTangent, translation (m) and rotation (rad).
struct SensorOffset : SmallAdam<6> {
  [[nodiscard]] PoseTangent tangent() const;
  /// A step of Adam. A gradient that is not finite moves nothing.
  void step(const PoseGradient& gradient, double translation_rate_m, double rotation_rate_rad);
};

/// The view from where the offset says the sensor is.
[[nodiscard]] View moved_by(const SensorOffset& offset, const View& view);
/// rig_from_sensor with the offset.
[[nodiscard]] Pose moved_by(const SensorOffset& offset, const Pose& rig_from_sensor);

/// By name of the sensor.
using SensorOffsets = std::map<std::string, SensorOffset>;
/// rig_from_sensor of that sensor, with its offset where it has one.
[[nodiscard]] Pose moved_by(const SensorOffsets& offsets,
                            const std::string& sensor,
                            const Pose& rig_from_sensor);

}  // namespace simuli
