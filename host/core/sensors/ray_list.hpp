#pragma once
// A LiDAR without a grid of rows and columns (solid state, rosettes, several heads): a list of individual rays.
// Frame and angles as in host/core/sensors/lidar.hpp.
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/core/sensors/lidar.hpp"

namespace simuli {

struct RayList {
  std::string name;
  std::vector<double> azimuth;  // [rays] rad, any period
  std::vector<double> elevation;        // [rays] rad, -pi/2 to pi/2
  std::vector<double> time_fraction;    // [rays] share of the frame at which the ray fires, -1 to 2
  std::vector<Eigen::Vector3d> origin;  // [rays] m, sensor frame; empty: all at the sensor's origin
  double sweep_s = kUsualSweep_s;  // s > 0, duration of a frame
  double range_min = 0.0;               // m
  double range_max = 0.0;               // m
  double beam_divergence = 0.0;         // rad, full angle; 0: an ideal ray
  double divergence_variance = 0.25;    // k of METHOD section 8: 0.25 for 1/e^2, 0.72 FWHM, 1 sigma

  [[nodiscard]] std::size_t ray_count() const { return azimuth.size(); }
  /// Unit direction of a ray in the sensor frame.
  [[nodiscard]] Eigen::Vector3d direction(std::size_t ray) const;
  /// Origin of a ray in the sensor frame, m.
  [[nodiscard]] Eigen::Vector3d ray_origin(std::size_t ray) const;
  bool operator==(const RayList&) const = default;
};

/// Throws Error{kInput} with `file` and field for lists of different lengths, without rays or with more than
/// 2^24, and for invalid values.
void validate(const RayList& list, const std::string& file);

}  // namespace simuli
