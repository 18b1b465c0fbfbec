#pragma once
#include "io/base/json_reader.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// {"type", "parameters"} as NVIDIA's programs exchange them; null for lenses that they have no name for (all
/// but pinholes, OpenCV's fisheye and f-theta). An ideal pinhole is an opencv-pinhole without distortion.
[[nodiscard]] Json camera_model_of(const Camera& camera);

inline constexpr const char* kUnknownLens = "unknown";

/// A camera as AlpaSim's rig_trajectories.json has it: {"logical_sensor_name", "sequence_id",
/// "unique_sensor_idx", "T_sensor_rig", "camera_model": {"type", "parameters"}}. The type is kUnknownLens for
/// lenses that it has no name for; what only f-theta cameras have is null in the others.
[[nodiscard]] Json camera_calibration(const LogCamera& camera,
                                      const std::string& sequence,
                                      std::size_t index);

/// Rows of a 4 x 4 matrix.
[[nodiscard]] Json rows_of(const Eigen::Matrix4d& matrix);

}  // namespace simuli
