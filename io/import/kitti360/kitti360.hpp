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
  std::string sequence;  // "2013_05_28_drive_0000_sync"; empty: the only one of data_poses
  std::filesystem::path output;
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();  // numbers of frames
  /// As KittiOptions::lidar.
  std::filesystem::path lidar = {};
};

struct Kitti360Report {
  KittiReport points;
  std::size_t absent = 0;   // frames' pictures and sweeps that are not there
  std::size_t unposed = 0;  // pictures and sweeps farther than 0.15 s from all poses, which are left out
};

/// Imports frames of a KITTI-360 sequence: the rectified pair image_00 and image_01, the fisheyes image_02
/// and image_03 (unified model), as far as their folders are there, and the HDL-64E. The rig is the velodyne,
/// the world its frame at the first pose. Layout and transforms after the data set's documentation and devkit
/// (cvlibs.net/datasets/kitti-360/documentation.php; autonomousvision/kitti360Scripts, helpers/project.py and
/// issues 42, 96 and 102): poses.txt has world_from_imu of the frames that it numbers, none where the car
/// stood nearly still, which lie between their neighbours. The velodyne's time is that of looking forward,
/// the middle of a turn. Boxes are not imported. Error{kInput} naming the file for what does not fit.
Log import_kitti360(const Kitti360Options& options,
                    const FrameProgress& progress,
                    Kitti360Report& report);

}  // namespace simuli
