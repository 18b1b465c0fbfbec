#include "optim/calibration/path/returns.hpp"

#include "io/log/frame_files.hpp"

namespace simuli::calibration {
namespace {

constexpr double kNearest_m = 2.0;  // nearer returns belong to the ego vehicle

}  // namespace

Returns returns_of(
    const Sweep& sweep, const LogLidar& lidar, double time_start_s, double time_end_s, bool reversed) {
  Returns out;
  out.time_start_s = time_start_s;
  out.time_end_s = time_end_s;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    const auto range = static_cast<double>(sweep.range[i]);
    if (!(range > 0.0)) continue;
    const auto azimuth = static_cast<double>(sweep.rays.azimuth[i]);
    const auto elevation = static_cast<double>(sweep.rays.elevation[i]);
    const Eigen::Vector3d p_lidar =
        ray_origin(lidar.model, sweep.rays, i) + range * Lidar::direction(azimuth, elevation);
    const auto forward = static_cast<double>(sweep.rays.time_fraction[i]);
    const double fraction = reversed ? 1.0 - forward : forward;
    if (!(p_lidar.norm() >= kNearest_m)) continue;
    out.p_rig.push_back(lidar.rig_from_lidar * p_lidar);
    out.time_s.push_back(time_start_s + fraction * (time_end_s - time_start_s));
    out.ray.push_back(static_cast<std::uint32_t>(i));
    out.intensity.push_back(sweep.intensity[i]);
  }
  return out;
}

Returns returns_of(const Log& log, const SweepFrame& frame, bool reversed) {
  const LogLidar& lidar = log.lidar(frame.lidar);
  const Sweep sweep = read_sweep(log, frame);
  return returns_of(sweep, lidar, frame.time_start_s, frame.time_end_s, reversed);
}

}  // namespace simuli::calibration
