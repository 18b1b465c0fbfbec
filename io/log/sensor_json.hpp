#pragma once
// Sensor models as JSON, shared by logs, scenes and files of their own: io/log/sensor_file.hpp says how.
#include "io/base/json_reader.hpp"
#include "io/log/sensor_file.hpp"

namespace simuli {

inline constexpr int kMostColumns = 1 << 20;  // of a LiDAR

/// {"name", "model", "width_px", ..., the model's parameters by lens_parameter_names(), "shutter"}
[[nodiscard]] Json to_json(const Camera& model);
/// Reads that and validates it. Without "model" it is a pinhole.
[[nodiscard]] Camera camera_model_from_json(JsonObject& object);

/// kind to rows or to the list.
[[nodiscard]] Json to_json(const LidarModel& model);
/// Reads that and validates it. A missing kind is "lidar", a missing radial_offset_m or range_bias_m 0, a row without fires_every fires always,
/// a missing sweep_s 0.1.
[[nodiscard]] LidarModel lidar_model_from_json(JsonObject& object);

/// The content of a sensor file.
[[nodiscard]] Json to_json(const CameraFile& file);
[[nodiscard]] Json to_json(const LidarFile& file);
[[nodiscard]] SensorFile sensor_file_from_json(JsonObject& object);

}  // namespace simuli
