// Consistency of returns with the planes of a trajectory's map.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "host/core/base/interruption.hpp"
#include "host/core/base/parallel.hpp"
#include "host/core/base/spread.hpp"
#include "optim/calibration/path/odometry.hpp"
#include "optim/calibration/path/plane_map.hpp"

namespace simuli::calibration {

using Eigen::Vector3d;

Fit fit_of(const std::vector<Returns>& sweeps, const std::vector<TimedPose>& path) {
  PlaneMap map;
  std::vector<std::vector<Vector3d>> p_world(sweeps.size());
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    p_world[s].resize(sweeps[s].size());
    parallel_each(sweeps[s].size(), [&](std::size_t i) {
      p_world[s][i] = world_point(path, sweeps[s].p_rig[i], sweeps[s].time_s[i]);
    });
    Interruption::ask();
    for (const Vector3d& p : p_world[s]) map.add(p);
  }
  map.update();
  std::size_t points = 0;
  std::vector<double> distances;
  for (const std::vector<Vector3d>& sweep : p_world) {
    points += sweep.size();
    Interruption::ask();
    for (const Vector3d& p : sweep) {
      const int found = map.find(p);
      if (found < 0) continue;
      distances.push_back(std::abs(map.plane(found).normal.dot(p - map.plane(found).centre)));
    }
  }
  Fit fit;
  if (distances.empty()) return fit;
  const auto count = static_cast<double>(distances.size());
  fit.planar_share = count / static_cast<double>(points);
  fit.outlier_share = static_cast<double>(std::count_if(
                          distances.begin(), distances.end(), [](double d) { return d > Fit::kOutlier_m; })) /
                      count;
  fit.median_m = upper_median(std::move(distances));
  return fit;
}

}  // namespace simuli::calibration
