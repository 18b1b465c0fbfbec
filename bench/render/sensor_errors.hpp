#pragma once
#include <functional>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"

namespace simuli::bench {

/// Rows of run_extremes(), and one line for each violated bound.
struct ExtremesReport {
  std::vector<Row> rows;
  std::vector<std::string> broken;
};

/// Compares the float build with the double build of the same kernels for single particles at the limits of
/// sensors (2 cm to 10 km, 0.01 mm to 1 km, aspect 1 : 1 000 000, 1e7 m from the world origin) and for all of
/// them together; camera and LiDAR, at rest, at 30 m/s and 90 degrees/s with the usual frame times, with
/// frames of 10 ms and of 1 s, and at 1000 degrees/s:
///   extremes/<sensor>_<motion>/<case>/transmittance_error, .../transmittance_bound   of 1, worst ray
///   extremes/.../distance_error, .../distance_bound      worst ray, relative to the larger of distance and
/// range
///   extremes/.../decided_otherwise                       share of rays with a hit in only one build
/// Throws Error{kDevice} without double precision.
[[nodiscard]] ExtremesReport run_extremes(const std::string& device_request,
                                          const std::function<void(const std::string&)>& note);

}  // namespace simuli::bench
