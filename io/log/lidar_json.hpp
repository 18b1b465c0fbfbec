#pragma once
// LiDAR models as JSON: io/log/lidar_file.hpp says how.
#include "io/base/json_reader.hpp"
#include "io/log/lidar_file.hpp"

namespace simuli {

/// The content of such a file.
[[nodiscard]] Json to_json(const LidarFile& file);

/// The part that logs and scenes share with it: kind to rows or to the list.
[[nodiscard]] Json to_json(const LidarModel& model);
/// Reads that part and validates it. A missing kind is "lidar", a missing radial_offset_m or range_bias_m 0,
/// a missing sweep_s 0.1.
[[nodiscard]] LidarModel lidar_model_from_json(JsonObject& object);

}  // namespace simuli
