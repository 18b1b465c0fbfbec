#pragma once
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>

#include "io/import/kitti/kitti.hpp"

namespace simuli {

struct Kitti360Options {
  /// Folder of the data set: calibration, data_2d_raw, data_3d_raw, data_poses.
  std::filesystem::path root;
  std::string sequence;  // "2013_05_28_drive_0000_sync"; empty: the only one in data_poses
  std::filesystem::path output;
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();  // frame numbers
  /// As in KittiOptions::lidar.
  std::filesystem::path lidar = {};
};

struct Kitti360Report {
  KittiReport points;
  std::size_t absent = 0;   // missing pictures and sweeps of frames
  std::size_t unposed = 0;  // pictures and sweeps more than 0.15 s from all poses, which are left out
};

/// Imports frames of a KITTI-360 sequence: the rectified pair image_00 and image_01 and the fisheyes image_02
/// and image_03 (unified model) if their folders exist, and the HDL-64E. The rig's frame is the velodyne's, and
/// the world frame is the velodyne's at the first pose. Layout and transforms follow the data set's
/// documentation and devkit (cvlibs.net/datasets/kitti-360/documentation.php; autonomousvision/kitti360Scripts,
/// helpers/project.py and issues 42, 96 and 102): poses.txt contains world_from_imu by frame number, without
/// frames in which the car was nearly at rest, which are interpolated. The velodyne's time stamp is that of the
/// forward direction, the middle of a sweep. Boxes are not imported. Throws Error{kInput} naming the file for
/// inconsistent data.
Log import_kitti360(const Kitti360Options& options, const FrameProgress& progress, Kitti360Report& report);

}  // namespace simuli
