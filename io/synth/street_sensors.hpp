#pragma once
// Sensors and motion of the synthetic streets' rig, for io/synth/*.cpp.
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/log/log.hpp"

namespace simuli {

inline constexpr double kStreetFramePeriod_s = 0.1;
inline constexpr double kStreetPosePeriod_s = 0.01;
inline constexpr int kStreetPosesOutside = 5;  // poses before the first and after the last sweep
inline constexpr double kStreetReadOut_s = 0.02;
inline constexpr double kStreetLane_m = -1.75;        // left of the road's centre
inline constexpr double kStreetLargestShift_m = 4.0;  // walls are farther from the lane

/// Returns a camera that looks ahead, 80 degrees wide.
[[nodiscard]] LogCamera street_front_camera(int width, int height, bool rolling_shutter);
/// Returns a LiDAR with 32 beams above the roof.
[[nodiscard]] LogLidar street_top_lidar(int columns);
/// Returns rig_from_road: small lateral motion with the corresponding heading, and pitch and roll of the
/// suspension.
[[nodiscard]] Pose street_sway(double driven_m);

/// Throws Error{kUsage} unless `good`; `option` is the name in `simuli synth street`, the only source of these
/// options.
template <class Value>
void check_street(bool good, const char* option, const Value& found, const char* allowed) {
  if (!good) throw Error(ErrorKind::kUsage, fmt::format("{}: found {}, allowed {}", option, found, allowed));
}

/// Checks the options that both streets share.
template <class Options>
void check_street_rig(const Options& o) {
  check_street(std::abs(o.lane_shift_m) <= kStreetLargestShift_m, "--lane-shift", o.lane_shift_m, "-4 to 4");
  check_street(o.image_width >= 8 && o.image_width <= 8192, "--image-width", o.image_width, "8 to 8192");
  check_street(o.image_height >= 8 && o.image_height <= 8192, "--image-height", o.image_height, "8 to 8192");
  check_street(
      o.lidar_columns >= 8 && o.lidar_columns <= 16384, "--lidar-columns", o.lidar_columns, "8 to 16384");
  check_street(o.threads >= 0 && o.threads <= 1024, "threads", o.threads, "0 to 1024");
}

}  // namespace simuli
