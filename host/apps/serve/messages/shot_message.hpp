#pragma once
// Conversion of poses, times and actors from messages.
#include <cstdint>
#include <string>

#include "host/apps/serve/messages/camera_message.hpp"
#include "host/apps/serve/session/served_scene.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli::serve {

[[nodiscard]] proto_common::Pose message_of(const Pose& pose);
/// Throws Refusal{kInvalid} naming `field` for a missing or invalid pose.
[[nodiscard]] Pose pose_of(const proto_common::Pose& message, const std::string& field);

/// Parts that requests for pictures and sweeps share.
struct FrameMessage {
  std::uint64_t start_us, end_us;
  const proto::PosePair& sensor_pose;
  const google::protobuf::RepeatedPtrField<proto::DynamicObject>& dynamic_objects;
};

/// Returns the shot of a picture. Actors in the request have its poses; all other actors are absent, except
/// inserted ones with tracks. A global shutter exposes at the frame's start. A rolling shutter exposes the
/// first row at the start and the last row at the end; this project's times refer to the picture's edges, half
/// a row beyond either. Throws Refusal{kInvalid} naming the field, Refusal{kOutOfRange}.
[[nodiscard]] Shot camera_shot(const ServedScene& scene, const FrameMessage& frame, const Camera& camera);
/// Returns the shot of a sweep: the first ray leaves at the start, and the revolution ends at the end.
[[nodiscard]] Shot lidar_shot(const ServedScene& scene, const FrameMessage& frame);

}  // namespace simuli::serve
