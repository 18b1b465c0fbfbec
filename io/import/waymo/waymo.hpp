#pragma once
#include <cstddef>
#include <filesystem>

#include "io/log/label_tracks.hpp"
#include "io/log/log.hpp"

namespace simuli {

struct WaymoOptions {
  std::filesystem::path segment;  // .tfrecord of frames (Perception, version 1)
  std::filesystem::path output;
};

struct WaymoReport {
  std::size_t frames = 0;
  std::size_t rays = 0;      // of all firing grids
  std::size_t returned = 0;  // of these
  LabelReport labels;
};

/// Imports a segment of the Waymo Open Dataset: all cameras (rolling shutters, from the middle of the first
/// exposed line's exposure to that of the last), the first returns of the LiDAR TOP from its range images,
/// boxes. The rig's frame is the vehicle frame. Intensities are tanh of the data set's. Principal points are
/// assumed to be relative to the centre of the first pixel, as in OpenCV. Throws Error{kInput} naming the file
/// and the message for inconsistent data.
Log import_waymo(const WaymoOptions& options, const FrameProgress& progress, WaymoReport& report);

}  // namespace simuli
