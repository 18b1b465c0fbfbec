#pragma once
#include <functional>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"

namespace simuli::bench {

/// The rows of run_extremes() and what in them breaks its bound, one line each.
struct ExtremesReport {
  std::vector<Row> rows;
  std::vector<std::string> broken;
};

/// Single particles at the ends of what sensors meet (2 cm to 10 km, 0.01 mm to 1 km, aspect 1 : 1 000 000,
/// 1e7 m from the world's origin), and all of them together, rendered by the float build against the double
/// build of the same kernels; camera and LiDAR, at rest, at 30 m/s and 90 degrees/s with the usual times,
/// with frames of 10 ms and of a second, and at 1000 degrees/s:
///   extremes/<sensor>_<motion>/<case>/transmittance_error, .../transmittance_bound   of 1, worst ray
///   extremes/.../distance_error, .../distance_bound      worst ray, of the larger of distance and range
///   extremes/.../decided_otherwise                       share of rays that only one of both builds hits
/// Error{kDevice} when the device has no double precision.
[[nodiscard]] ExtremesReport run_extremes(const std::string& device_request,
                                          const std::function<void(const std::string&)>& note);

}  // namespace simuli::bench
