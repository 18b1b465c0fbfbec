#pragma once
// Returns of a sweep for calibration, each in the rig's frame at its own time.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/log/log.hpp"

namespace simuli::calibration {

struct Returns {
  std::vector<Eigen::Vector3d> p_rig;  // [N] m, rig frame at time_s
  std::vector<double> time_s;          // [N] since the log's start
  std::vector<std::uint32_t> ray;      // [N] row * columns + column
  std::vector<float> intensity;        // [N] in [0, 1]
  double time_start_s = 0.0;           // of the sweep
  double time_end_s = 0.0;

  [[nodiscard]] std::size_t size() const { return p_rig.size(); }
};

/// Returns the returns of a sweep in firing grid order, without those of the ego vehicle (nearer than 2 m).
/// With `reversed` the sensor spins the other way: a ray at share f of the sweep fires at 1 - f.
[[nodiscard]] Returns returns_of(const Log& log, const SweepFrame& frame, bool reversed = false);
[[nodiscard]] Returns returns_of(
    const Sweep& sweep, const LogLidar& lidar, double time_start_s, double time_end_s, bool reversed = false);

}  // namespace simuli::calibration
