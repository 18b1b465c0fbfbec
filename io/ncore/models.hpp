#pragma once
// NCore's intrinsics of sensors, for io/ncore, io/import/ncore and tests.
#include <string>

#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::ncore {

/// Returns {"camera_model_type", "camera_model_parameters"}; null for lenses that NCore does not support.
[[nodiscard]] Json intrinsics_of(const Camera& camera);
/// Returns {"lidar_model_type", "lidar_model_parameters"}; null for ray lists and beams with equal elevations,
/// which NCore's model does not support.
[[nodiscard]] Json intrinsics_of(const LidarModel& lidar);

/// Throws Error{kInput} naming file and field for an unknown model and for impossible values.
[[nodiscard]] Camera camera_from_intrinsics(JsonObject& intrinsics, const std::string& name);
/// Returns a LiDAR with range 0, because NCore has no range. Columns are evenly spaced from the first to the
/// last; throws Error{kInput} if one differs by more than half a column.
[[nodiscard]] Lidar lidar_from_intrinsics(JsonObject& intrinsics, const std::string& name);

/// Whether two documents are equal in single precision, to which NCore's package rounds.
[[nodiscard]] bool is_same(const Json& a, const Json& b);

}  // namespace simuli::ncore
