#pragma once
// The rig of the synthetic streets: what it carries, and how it drives. Included by io/synth/*.cpp alone.
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

}  // namespace simuli
