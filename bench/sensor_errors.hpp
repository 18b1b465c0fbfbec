#pragma once
#include <functional>
#include <string>
#include <vector>

#include "bench/measure.hpp"

namespace simuli::bench {

/// The rows of run_extremes() and what in them breaks its bound, one line each.
struct ExtremesReport {
  std::vector<Row> rows;
  std::vector<std::string> broken;
};

/// Single particles at the ends of what sensors meet (5 cm to 2 km, 0.1 mm to 100 m, aspect 1:10 000, 1e6 m
/// from the world's origin), and all of them together, rendered by the float build against the double build
/// of the same kernels; camera and LiDAR, at rest and moving:
///   extremes/<sensor>_<rest|moving>/<case>/transmittance_error, .../transmittance_bound   of 1, worst ray
///   extremes/.../distance_error, .../distance_bound      worst ray, of the larger of distance and range
///   extremes/.../decided_otherwise                       share of rays that only one of both builds hits
/// Error{kDevice} when the device has no double precision.
[[nodiscard]] ExtremesReport run_extremes(const std::string& device_request,
                                          const std::function<void(const std::string&)>& note);

}  // namespace simuli::bench
