#pragma once
// The rig of the synthetic streets: what it carries, and how it drives. Included by io/synth/*.cpp alone.
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/log/log.hpp"

namespace simuli {

inline constexpr double kStreetFramePeriod_s = 0.1;
inline constexpr double kStreetPosePeriod_s = 0.01;
inline constexpr int kStreetPosesOutside = 5;  // poses before the first and after the last sweep
inline constexpr double kStreetReadOut_s = 0.02;
inline constexpr double kStreetLane_m = -1.75;        // left of the road's middle
inline constexpr double kStreetLargestShift_m = 4.0;  // walls stand further from the lane

/// Looks ahead, 80 degrees wide.
[[nodiscard]] LogCamera street_front_camera(int width, int height, bool rolling_shutter);
/// 32 beams above the roof.
[[nodiscard]] LogLidar street_top_lidar(int columns);
/// rig_from_road's sway: a little to the left and right, where it heads where it drives, and nods and leans
/// on its springs.
[[nodiscard]] Pose street_sway(double driven_m);

/// Throws Error{kUsage} unless `good`; `option` as `simuli synth street` names it, which alone gives them.
template <class Value>
void check_street(bool good, const char* option, const Value& found, const char* allowed) {
  if (!good) throw Error(ErrorKind::kUsage, fmt::format("{}: found {}, allowed {}", option, found, allowed));
}

/// What the options of both streets have in common.
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
