#pragma once
// Learns LiDAR parameters that logs do not contain from their sweeps, before a scene is initialised.
#include <optional>
#include <vector>

#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// Returns the log with LiDAR parameters learned from its training sweeps (range_bias.hpp, ego_vehicle.hpp,
/// range_limit.hpp). Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] Log with_learned_sensors(Log log, const FrameSelection& frames);

// Finds the directions in which a mounted LiDAR sees the ego vehicle, from the sweeps.

/// Returns arcs of every row of log.lidars[i], at least 5 degrees below the horizon, that see the ego vehicle:
/// no training sweep has a return there although the beam points at the ground, with at least 5 m driven
/// between the first and the last sweep, because surroundings of a parked car are no part of it; or, with at
/// least 1 m driven, returns nearer than 3 m, within 1.25 m of the rig's middle and less than half as far below
/// the sensor as the ground, are at a constant position in the rig (0.1 m). Empty for a sensor with fewer than
/// 8 training sweeps. Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] std::vector<std::vector<BlindArc>> find_blind_arcs(const Log& log,
                                                                 const FrameSelection& frames);

/// Returns the log with these arcs for LiDARs that have none.
[[nodiscard]] Log with_blind_arcs(Log log, const FrameSelection& frames);

// Per-beam range calibration of a LiDAR, from surfaces seen by several rows.

/// Range bias of a row and its uncertainty.
struct RangeBias {
  double bias_m = 0.0;   // measured minus true distance
  double sigma_m = 0.0;  // standard deviation of bias_m; +inf without information
};

/// Returns range biases of the rows of `lidar`, one of log.lidars: returns of training sweeps, placed by the
/// ego poses and the current biases, must lie on planes common to all rows (three rounds of robust least
/// squares). A bias common to all rows is not observable, so the median over rows is 0. Empty for fewer than 8
/// training sweeps. Throws Error{kInput} when a sweep cannot be read.
[[nodiscard]] std::vector<RangeBias> find_range_bias(const Log& log,
                                                     const LogLidar& lidar,
                                                     const FrameSelection& frames);

/// Returns the log with significant biases (5 standard deviations and 5 mm), for LiDARs that have none.
[[nodiscard]] Log with_range_bias(Log log, const FrameSelection& frames);

// Estimates the recorded range limit of a LiDAR from its sweeps; tables only contain the sensor's capability.

/// Returns the range in m at which a recording was cut off: slightly more than the largest range of all
/// training sweeps, if returns are as dense in the last metre as in the metre before instead of becoming rare.
/// No value otherwise, or with fewer than 50 returns in that metre. Throws Error{kInput} when a sweep cannot be
/// read.
[[nodiscard]] std::optional<double> find_range_limit(const Log& log,
                                                     const LogLidar& lidar,
                                                     const FrameSelection& frames);

/// Returns the log with LiDARs limited to that range.
[[nodiscard]] Log with_range_limit(Log log, const FrameSelection& frames);

}  // namespace simuli
