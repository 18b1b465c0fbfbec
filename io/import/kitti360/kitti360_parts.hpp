#pragma once
// Calibration and poses of KITTI-360. For io/kitti360*.cpp and tests.
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::kitti360 {

struct Calibration {
  std::vector<LogCamera> cameras;  // on the velodyne
  Pose imu_from_velo;
};

/// From the folder `calibration` (perspective.txt, image_0X.yaml, calib_cam_to_pose.txt,
/// calib_cam_to_velo.txt), of the cameras named. Error{kInput} naming file and key.
[[nodiscard]] Calibration read_calibration(const std::filesystem::path& folder,
                                           const std::vector<std::string>& cameras);

/// A fisheye's image_0X.yaml: OpenCV's YAML, a value a line, model_type MEI.
[[nodiscard]] Camera read_fisheye(const std::filesystem::path& file, const std::string& name);

/// poses.txt: world_from_imu by number of frame. Error{kInput} with the line for anything but a number and a
/// rigid 3 x 4 matrix, and for numbers that do not rise.
[[nodiscard]] std::map<std::size_t, Pose> read_poses(const std::filesystem::path& file);

}  // namespace simuli::kitti360
