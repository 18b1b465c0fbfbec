#pragma once
// Conversion of cameras from and to messages.
#include "host/core/sensors/camera.hpp"
#include "sensorsim.pb.h"

namespace simuli::serve {

namespace proto = ::nre::grpc::protos::sensorsim;
namespace proto_common = ::nre::grpc::protos::common;

/// Omits lenses of families that the protocol lacks (mei, equirectangular, double_sphere, eucm); requests may
/// select such a camera of the scene by its logical_id.
[[nodiscard]] proto::CameraSpec spec_of(const Camera& camera);

/// Converts a camera with a lens. Throws Refusal{kInvalid} naming the field, Error{kInput} for impossible
/// values.
[[nodiscard]] Camera camera_of(const proto::CameraSpec& spec);

}  // namespace simuli::serve
