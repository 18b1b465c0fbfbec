#pragma once
// Cameras as messages say them.
#include "host/core/sensors/camera.hpp"
#include "sensorsim.pb.h"

namespace simuli::serve {

namespace proto = ::nre::grpc::protos::sensorsim;
namespace proto_common = ::nre::grpc::protos::common;

/// A lens of a family that the protocol lacks (mei, equirectangular, double_sphere, eucm) is left out:
/// requests may then name the scene's camera by its logical_id alone.
[[nodiscard]] proto::CameraSpec spec_of(const Camera& camera);

/// Of one with a lens. Refusal{kInvalid} naming the field,
/// Error{kInput} for numbers that no camera has.
[[nodiscard]] Camera camera_of(const proto::CameraSpec& spec);

}  // namespace simuli::serve
