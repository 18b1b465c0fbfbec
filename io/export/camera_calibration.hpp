#pragma once
#include "io/base/json_reader.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Returns {"type", "parameters"} in the format of NVIDIA's programs; null for lenses without a type there (all
/// except pinholes, OpenCV's fisheye and f-theta). An ideal pinhole is an opencv-pinhole without distortion.
[[nodiscard]] Json camera_model_of(const Camera& camera);

inline constexpr const char* kUnknownLens = "unknown";

/// Returns a camera as in AlpaSim's rig_trajectories.json: {"logical_sensor_name", "sequence_id",
/// "unique_sensor_idx", "T_sensor_rig", "camera_model": {"type", "parameters"}}. The type is kUnknownLens for
/// lenses without a type; parameters of f-theta cameras are null for others.
[[nodiscard]] Json camera_calibration(const LogCamera& camera,
                                      const std::string& sequence,
                                      std::size_t index);

/// Returns the rows of a 4 x 4 matrix.
[[nodiscard]] Json rows_of(const Eigen::Matrix4d& matrix);

}  // namespace simuli
