#pragma once
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "io/import/points/point_grid.hpp"
#include "io/import/points/unit_offset.hpp"
#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"

namespace simuli {

struct PandasetOptions {
  /// Folder of one sequence (".../pandaset/002"): camera, lidar, annotations.
  std::filesystem::path sequence;
  std::filesystem::path output;
  std::vector<std::string> cameras = {};  // of the folders in camera; empty: all
  std::vector<std::string> lidars = {};   // of pandar64, pandargt; empty: both
  /// Numbers of the frames, both ends among them; the largest number: up to the sequence's end.
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();
};

/// Frames that a sensor lacks though the sequence lists them.
struct PandasetGap {
  std::string sensor;  // or "all sensors"
  std::vector<std::size_t> frames;
};

/// How well one mounting explains the poses of a camera's pictures.
struct PandasetMount {
  std::string camera;
  std::size_t poses = 0;
  double off_m = 0.0, off_rad = 0.0;  // root mean squares
};

struct PandasetReport {
  std::vector<PandasetGap> gaps;
  std::vector<PandasetMount> mounts;
  std::vector<std::string> hidden;  // cameras that see the vehicle, whose masks hide it
  // The Pandar64.
  PointReport points;
  UnitMounting mounting;  // its rows' off the published one
  bool is_clockwise = false;
  double spin_agreement = 0.0;  // of its points' times and directions with an even turn, 0 to 1
  // The PandarGT.
  std::size_t list_rays = 0;      // of each of its sweeps
  std::size_t list_points = 0;    // of all of them
  std::size_t list_repeated = 0;  // rays that say a point again, to make that many
  std::size_t list_again = 0;     // sweeps that another frame has, too; left out
  // Boxes.
  LabelReport labels;
  std::size_t boxes_twice = 0;     // of the PandarGT, of objects that the Pandar64 shows in that frame; left out
  std::size_t boxes_by_front = 0;  // without a point inside: at the time of the front camera
};

/// Imports frames of a PandaSet sequence. The world is the rig's frame at the sequence's first pose,
/// whichever frames are imported; the rig is the Pandar64's place, x forward. Poses are the front camera's
/// and the published mounting of that: lidar/poses.json has none of the LiDAR. Other cameras: the least
/// squares mean of their pictures' poses on the rig. Pictures (undistorted pinholes) are read out from top to
/// bottom, from 25 ms before their stamp to 5 ms after it. Pandar64: on the firing grid of its table, whose
/// spin is found from the points, and where it stands off the published mounting. PandarGT: as the rays of
/// its points, for what it fired in vain is not recorded. A box stands at the time at which its LiDAR saw it:
/// the median of the points inside.
/// Files that are not there are gaps. Error{kInput} naming file and field for anything else that does not
/// fit, and for more than 5 % of the Pandar64's points on no ray; Error{kUsage} for sensors that it has not.
Log import_pandaset(const PandasetOptions& options,
                    const FrameProgress& progress,
                    PandasetReport& report);

}  // namespace simuli
