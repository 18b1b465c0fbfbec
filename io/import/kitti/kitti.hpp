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
  /// The rig rests where it is: for logs whose path is found later (`simuli align`).
  bool without_poses = false;
  /// Beam table to read the sweeps with, of a sensor that turns clockwise; empty: the built-in kitti_hdl64e.
  std::filesystem::path lidar = {};
  /// Of the colour cameras "image_02" (left) and "image_03" and the grey ones "image_00" and "image_01";
  /// empty: the left one that sees colours.
  std::vector<std::string> cameras = {};
  /// Numbers of the frames, both ends among them; the largest number: up to the drive's end.
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();
};

/// Frames that a sensor lacks: lost while recording, or empty.
struct KittiGaps {
  std::string sensor;
  std::vector<std::size_t> frames;
};

/// Where a sensor's clock jumped or it stood still for a while: between `frame` and the one before it.
struct KittiJump {
  std::string sensor;
  std::size_t frame = 0;
  double step_s = 0.0;
};

/// What became of the points; shares are of these counts.
struct KittiReport {
  std::size_t points = 0;              // in the sweeps' files
  std::size_t unplaced = 0;            // belong to no beam and are not in the log (above 0.5 %: an error)
  std::size_t ring_agrees = 0;         // placed points whose ring in the file is the beam of their elevation
  std::size_t rays = 0;                // of all firing grids
  std::size_t returned = 0;            // rays with a return: points - unplaced
  double azimuth_shift_max_rad = 0.0;  // farthest that a measured ray lies from its column's even spacing
  std::vector<KittiGaps> gaps;         // of the sensors that have any, and of oxts
  std::vector<KittiGaps> disordered;   // left out: times that are not between those before and behind
  LabelReport labels;                  // of the file KittiOptions::tracking
  std::vector<KittiJump> jumps;        // steps of at least half a second more than is usual
};

/// Imports frames of a KITTI raw drive (cameras, HDL-64E, oxts) and writes the log folder. The rig's
/// frame is the velodyne's, the world's is that at the first pose. The output appears complete or not at all.
/// `progress(done, total)` is called after every frame. A picture or a sweep that is not there, or a sweep's
/// file without a byte, or a record of oxts that is not there, is a gap of that sensor; drives have them.
/// Where times run backwards, as few frames as possible are left out for the others to be in order.
/// Error{kInput} naming the file for anything else that is missing, truncated or not a number, and for a
/// sensor that recorded none of the frames.
Log import_kitti(const KittiOptions& options,
                 const FrameProgress& progress = {},
                 KittiReport* report = nullptr);

}  // namespace simuli
