#pragma once
// Sensors as NCore's intrinsics have them. For io/ncore, io/import/ncore and tests.
#include <string>

#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::ncore {

/// {"camera_model_type", "camera_model_parameters"}; null for lenses that NCore has no name for.
[[nodiscard]] Json intrinsics_of(const Camera& camera);
/// {"lidar_model_type", "lidar_model_parameters"}; null for what NCore's one model can't say: lists of rays,
/// and rows of one elevation.
[[nodiscard]] Json intrinsics_of(const LidarModel& lidar);

/// Error{kInput} naming file and field for a model that is not known or that no camera has.
[[nodiscard]] Camera camera_from_intrinsics(JsonObject& intrinsics, const std::string& name);
/// Ranges are left 0: NCore has none. Columns are evenly spread from the first to the last; Error{kInput}
/// where they are farther than half a column from that.
[[nodiscard]] Lidar lidar_from_intrinsics(JsonObject& intrinsics, const std::string& name);

/// Whether two documents say the same with numbers of single precision, which NCore's own package rounds to.
[[nodiscard]] bool is_same(const Json& a, const Json& b);

}  // namespace simuli::ncore
