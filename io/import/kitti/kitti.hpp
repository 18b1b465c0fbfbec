#pragma once
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"

namespace simuli {

struct KittiOptions {
  /// Folder of one drive (".../2011_09_26_drive_0013_sync"), calibration in its parent.
  std::filesystem::path drive;
  /// JSON with "frames": [{"index", "world_from_velo" 4x4 at "t_sweep_forward", ...}]; empty: poses from
  /// oxts, interpolated by timestamp.
  std::filesystem::path poses = {};
  std::filesystem::path output;
  /// Label file of the KITTI tracking benchmark whose frames are the drive's; empty: no actors.
  std::filesystem::path tracking = {};
  /// The rig does not move: for logs whose trajectory is determined later (`simuli align`).
  bool without_poses = false;
  /// Beam table of the sweeps, of a sensor that rotates clockwise; empty: the built-in kitti_hdl64e.
  std::filesystem::path lidar = {};
  /// The colour cameras "image_02" (left) and "image_03" and the grey cameras "image_00" and "image_01"; empty:
  /// the left colour camera.
  std::vector<std::string> cameras = {};
  /// Frame numbers, inclusive; the largest number: to the drive's end.
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();
};

/// Frames that a sensor lacks: lost while recording, or empty.
struct KittiGaps {
  std::string sensor;
  std::vector<std::size_t> frames;
};

/// A jump of a sensor's clock, or a pause, between `frame` and the previous one.
struct KittiJump {
  std::string sensor;
  std::size_t frame = 0;
  double step_s = 0.0;
};

/// Counts of points and frames.
struct KittiReport {
  std::size_t points = 0;              // in the sweeps' files
  std::size_t unplaced = 0;            // assigned to no beam and left out (above 0.5 %: an error)
  std::size_t ring_agrees = 0;         // placed points whose ring in the file is the beam of their elevation
  std::size_t rays = 0;                // of all firing grids
  std::size_t returned = 0;            // rays with a return: points - unplaced
  double azimuth_shift_max_rad = 0.0;  // largest distance of a measured ray from its column's even spacing
  std::vector<KittiGaps> gaps;         // of sensors with gaps, and of oxts
  std::vector<KittiGaps> disordered;   // left out: times that are not between those of their neighbours
  LabelReport labels;                  // of the file KittiOptions::tracking
  std::vector<KittiJump> jumps;        // steps at least half a second longer than usual
};

/// Imports frames of a KITTI raw drive (cameras, HDL-64E, oxts) and writes the log folder atomically. The rig's
/// frame is the velodyne's, and the world frame is the velodyne's at the first pose. Calls `progress(done,
/// total)` after every frame. A missing picture, sweep or oxts record and an empty sweep file are gaps of that
/// sensor, which drives contain. Where times decrease, the smallest number of frames is left out such that the
/// others are in order. Throws Error{kInput} naming the file for other missing, truncated or non-numeric data,
/// and for a sensor without any of the frames.
Log import_kitti(const KittiOptions& options,
                 const FrameProgress& progress = {},
                 KittiReport* report = nullptr);

}  // namespace simuli
