#pragma once
// Poses, times and actors as messages say them.
#include <cstdint>
#include <string>

#include "host/apps/serve/messages/camera_message.hpp"
#include "host/apps/serve/session/served_scene.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/device/render/scene/shot.hpp"

namespace simuli::serve {

[[nodiscard]] proto_common::Pose message_of(const Pose& pose);
/// Refusal{kInvalid} naming `field` for one that is missing or none.
[[nodiscard]] Pose pose_of(const proto_common::Pose& message, const std::string& field);

/// What requests for pictures and sweeps have in common.
struct FrameMessage {
  std::uint64_t start_us, end_us;
  const proto::PosePair& sensor_pose;
  const google::protobuf::RepeatedPtrField<proto::DynamicObject>& dynamic_objects;
};

/// Actors that are named are where the request has them; all others are not there, but who was inserted with
/// a track of its own. A global shutter's moment is the frame's start. A rolling one's first row is exposed
/// at the start and its last at the end; ours count from the picture's edge to its other edge, half a row
/// more at either end. Refusal{kInvalid} naming the field, Refusal{kOutOfRange}.
[[nodiscard]] Shot camera_shot(const ServedScene& scene, const FrameMessage& frame, const Camera& camera);
/// The same of a LiDAR, whose first ray leaves at the start and which is back there at the end.
[[nodiscard]] Shot lidar_shot(const ServedScene& scene, const FrameMessage& frame);

}  // namespace simuli::serve
