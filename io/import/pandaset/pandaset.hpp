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
  std::vector<std::string> cameras = {};  // folders in camera; empty: all
  std::vector<std::string> lidars = {};   // pandar64, pandargt; empty: both
  /// Frame numbers, inclusive; the largest number: to the sequence's end.
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();
};

/// Frames that a sensor lacks although the sequence lists them.
struct PandasetGap {
  std::string sensor;  // or "all sensors"
  std::vector<std::size_t> frames;
};

/// Deviation of the poses of a camera's pictures from one mounting.
struct PandasetMount {
  std::string camera;
  std::size_t poses = 0;
  double off_m = 0.0, off_rad = 0.0;  // root mean squares
};

struct PandasetReport {
  std::vector<PandasetGap> gaps;
  std::vector<PandasetMount> mounts;
  std::vector<std::string> hidden;  // cameras that show the ego vehicle, which their masks hide
  // The Pandar64.
  PointReport points;
  UnitMounting mounting;  // deviation of its beams from the published mounting
  bool is_clockwise = false;
  double spin_agreement =
      0.0;  // agreement of its points' times and directions with a uniform rotation, 0 to 1
  // The PandarGT.
  std::size_t list_rays = 0;      // per sweep
  std::size_t list_points = 0;    // of all of them
  std::size_t list_repeated = 0;  // rays that repeat a point
  std::size_t list_again = 0;     // sweeps that another frame contains as well; left out
  // Boxes.
  LabelReport labels;
  // boxes of the PandarGT whose objects the Pandar64 shows in that frame; left out
  std::size_t boxes_twice = 0;
  std::size_t boxes_by_front = 0;  // without points inside: they get the time of the front camera
};

/// Imports frames of a PandaSet sequence. The world frame is the rig's at the sequence's first pose,
/// independent of the imported frames; the rig's frame is at the Pandar64, x forward. The trajectory is that of
/// the front camera with its published mounting, because lidar/poses.json does not contain the LiDAR's.
/// Mountings of other cameras are the least-squares means of their pictures' poses on the rig. Pictures
/// (undistorted pinholes) are read out from top to bottom, from 25 ms before their stamp to 5 ms after it. The
/// Pandar64 is imported on the firing grid of its table; its rotation and deviations from the published
/// mounting are estimated from the points. The PandarGT is imported as the rays of its points, because firings
/// without return are not recorded. A box gets the time at which its LiDAR scanned it: the median time of the
/// points inside.
/// Missing files are gaps. Throws Error{kInput} naming file and field for other inconsistent data, and if more
/// than 5 % of the Pandar64's points are assigned to no beam; Error{kUsage} for unknown sensors.
Log import_pandaset(const PandasetOptions& options, const FrameProgress& progress, PandasetReport& report);

}  // namespace simuli
