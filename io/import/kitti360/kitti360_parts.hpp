#pragma once
// Calibration and poses of KITTI-360, for io/import/kitti360/*.cpp and tests.
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::kitti360 {

struct Calibration {
  std::vector<LogCamera> cameras;  // mounted on the velodyne
  Pose imu_from_velo;
};

/// Reads the named cameras from the folder `calibration` (perspective.txt, image_0X.yaml,
/// calib_cam_to_pose.txt, calib_cam_to_velo.txt). Throws Error{kInput} naming file and key.
[[nodiscard]] Calibration read_calibration(const std::filesystem::path& folder,
                                           const std::vector<std::string>& cameras);

/// Reads a fisheye's image_0X.yaml: OpenCV's YAML with one value per line, model_type MEI.
[[nodiscard]] Camera read_fisheye(const std::filesystem::path& file, const std::string& name);

/// Reads poses.txt: world_from_imu by frame number. Throws Error{kInput} with the line unless it contains a
/// number and a rigid 3 x 4 matrix, and for numbers that do not increase.
[[nodiscard]] std::map<std::size_t, Pose> read_poses(const std::filesystem::path& file);

}  // namespace simuli::kitti360
