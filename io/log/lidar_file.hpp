#pragma once
// LiDAR models as JSON, in logs, in scenes and in files of their own. A file of its own is what
// `simuli info NAME --json` prints, so that a built-in model is the start of a custom one:
//
//   {"kind": "lidar", "name": "my sensor",
//    "source": "...", "licence": "...", "note": "...",               these four may be missing
//    "modes": [{"spin_hz": 10, "columns": 2000}, ...],               the model's own mode first
//    "sweep_s": 0.1,                                                 may be missing: one turn of that mode
//    "columns": 2000, "azimuth_first_rad": 3.14, "azimuth_span_rad": 6.283185307179586,
//    "spin": "clockwise" or "counter_clockwise",
//    "range_min_m": 0.5, "range_max_m": 120, "beam_divergence_rad": 0.003, "divergence_variance": 0.25,
//    "rows": [{"elevation_rad": 0.26, "azimuth_offset_rad": 0, "vertical_offset_m": 0,
//              "horizontal_offset_m": 0, "time_offset_s": 0, "radial_offset_m": 0, "range_bias_m": 0}, ...]}
//
// with rows from top to bottom, fields as in host/sensors/lidar.hpp; and for a sensor without rows
//
//   {"kind": "ray_list", "name": "my sensor", "sweep_s": 0.1, "range_min_m": 0.5, "range_max_m": 120,
//    "beam_divergence_rad": 0.003, "divergence_variance": 0.25,
//    "azimuth_rad": [...], "elevation_rad": [...], "time_fraction": [...],      one value per ray
//    "origin_m": [x0, y0, z0, x1, ...]}                                        may be missing: the sensor's
//
// fields as in host/sensors/ray_list.hpp. A sweep_s that no mode tells either is 0.1. Any other key is an
// error.
#include <filesystem>

#include "host/sensors/lidar_library.hpp"
#include "host/sensors/lidar_model.hpp"

namespace simuli {

struct LidarFile {
  LidarModel model;
  LidarFacts facts;  // empty texts and no modes where the file has none
};

/// Error{kInput} naming file and field for bad syntax, missing, unknown or twice written keys, and models
/// that validate() refuses.
[[nodiscard]] LidarFile read_lidar_file(const std::filesystem::path& file);

/// Error{kInput} for a model that validate() refuses, and when it can't be written. Atomic.
void write_lidar_file(const std::filesystem::path& path, const LidarFile& file);

}  // namespace simuli
