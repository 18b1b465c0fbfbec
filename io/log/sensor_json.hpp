#pragma once
// Sensor models as JSON in logs, scenes and sensor files; io/log/sensor_file.hpp describes the format.
#include "io/base/json_reader.hpp"
#include "io/log/sensor_file.hpp"

namespace simuli {

inline constexpr int kMostColumns = 1 << 20;  // of a LiDAR

/// {"name", "model", "width_px", ..., the model's parameters by lens_parameter_names(), "shutter"}
[[nodiscard]] Json to_json(const Camera& model);
/// Reads a camera and validates it. Without "model" it is a pinhole.
[[nodiscard]] Camera camera_model_from_json(JsonObject& object);

/// The keys from "kind" to "rows", or those of a ray list.
[[nodiscard]] Json to_json(const LidarModel& model);
/// Reads a LiDAR and validates it. Defaults of missing keys: kind "lidar", radial_offset_m and range_bias_m 0, fires_every
/// 1, sweep_s 0.1.
[[nodiscard]] LidarModel lidar_model_from_json(JsonObject& object);

/// The content of a sensor file.
[[nodiscard]] Json to_json(const CameraFile& file);
[[nodiscard]] Json to_json(const LidarFile& file);
[[nodiscard]] SensorFile sensor_file_from_json(JsonObject& object);

}  // namespace simuli
