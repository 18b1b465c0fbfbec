#pragma once
// Cameras and LiDARs as JSON files of their own, for any command that takes a sensor. A file is what
// `simuli info NAME --json` prints, so that a built-in model is the start of a custom one. A camera:
//
//   {"kind": "camera", "name": "my camera",
//    "source": "...", "licence": "...", "note": "...",               these three may be missing
//    "model": "opencv_fisheye",                                      may be missing: a pinhole
//    "width_px": 1920, "height_px": 1080, "fx_px": 600, "fy_px": 600, "cx_px": 960, "cy_px": 540,
//    "k1": 0.01, ..., "max_angle_rad": 1.5,                          the lens's, by lens_parameter_names()
//    "shutter": "global", "top_to_bottom", "bottom_to_top", "left_to_right" or "right_to_left",
//    "readout_s": 0.03}                                              of a rolling shutter; may be missing
//
// with fields as in host/core/sensors/camera.hpp. A LiDAR:
//
//   {"kind": "lidar", "name": "my sensor",
//    "source": "...", "licence": "...", "note": "...",               these four may be missing
//    "modes": [{"spin_hz": 10, "columns": 2000}, ...],               the model's own mode first
//    "sweep_s": 0.1,                                                 may be missing: one turn of that mode
//    "columns": 2000, "azimuth_first_rad": 3.14, "azimuth_span_rad": 6.283185307179586,
//    "spin": "clockwise" or "counter_clockwise",
//    "range_min_m": 0.5, "range_max_m": 120, "beam_divergence_rad": 0.003, "divergence_variance": 0.25,
//    "rows": [{"elevation_rad": 0.26, "azimuth_offset_rad": 0, "vertical_offset_m": 0,
//              "horizontal_offset_m": 0, "time_offset_s": 0, "radial_offset_m": 0, "range_bias_m": 0,
//              "fires_every": 2, "fires_first": 0}, ...]}              in columns; may be missing: fires in each
//
// with rows from top to bottom, fields as in host/core/sensors/lidar.hpp; and for a sensor without rows
//
//   {"kind": "ray_list", "name": "my sensor", "sweep_s": 0.1, "range_min_m": 0.5, "range_max_m": 120,
//    "beam_divergence_rad": 0.003, "divergence_variance": 0.25,
//    "azimuth_rad": [...], "elevation_rad": [...], "time_fraction": [...],      one value per ray
//    "origin_m": [x0, y0, z0, x1, ...]}                                        may be missing: the sensor's
//
// fields as in host/core/sensors/ray_list.hpp. Without sweep_s and modes a sweep takes 0.1 s. Any other key is an
// error.
#include <filesystem>
#include <string>
#include <variant>

#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/core/sensors/sensor.hpp"

namespace simuli {

struct CameraFile {
  Camera model;
  double readout_s = 0.0;  // from the first to the last exposure of a rolling shutter; 0: not stated
  std::string source = {}, licence = {}, note = {};  // as in LidarFacts
};

struct LidarFile {
  LidarModel model;
  LidarFacts facts = {};  // empty if the file has none
};

using SensorFile = std::variant<CameraFile, LidarFile>;

/// Error{kInput} naming file and field for bad syntax, missing, unknown or twice written keys, and models
/// that validate() refuses.
[[nodiscard]] SensorFile read_sensor_file(const std::filesystem::path& file);
/// As read_sensor_file(), with Error{kInput} for a sensor of the other kind.
[[nodiscard]] CameraFile read_camera_file(const std::filesystem::path& file);
[[nodiscard]] LidarFile read_lidar_file(const std::filesystem::path& file);

/// Reads a sensor from the text of a file; errors name `where`.
[[nodiscard]] SensorFile sensor_file_from_text(const std::string& text, const std::string& where);
[[nodiscard]] std::string text_of(const SensorFile& file);
/// Writes a sensor file atomically. Error{kInput} for a model that validate() refuses and for a failed write.
void write_sensor_file(const std::filesystem::path& path, const SensorFile& file);

/// Returns the sensor, mounted at the origin of its rig.
[[nodiscard]] Sensor sensor_of(const SensorFile& file);
/// Returns the file content of a sensor, without the duration of a global shutter; measured rays are replaced by those of
/// the model.
[[nodiscard]] SensorFile sensor_file_of(const Sensor& sensor);

}  // namespace simuli
