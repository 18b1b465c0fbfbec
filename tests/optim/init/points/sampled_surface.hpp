#pragma once
// Points of sweeps: a patch of a surface, hit by rays with known steps.
#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "optim/init/points/points.hpp"

namespace simuli::test {

/// Returns the sight of p from a sensor at `eye` with steps of column_rad and row_rad.
inline Sight sight_of(const Eigen::Vector3d& eye,
                      const Eigen::Vector3d& p,
                      double column_rad,
                      double row_rad) {
  const Eigen::Vector3d towards = (p - eye).normalized();
  const Eigen::Vector3d across = Eigen::Vector3d::UnitZ().cross(towards).normalized();
  return {static_cast<float>((p - eye).norm()),
          towards.cast<float>(),
          (column_rad * across).cast<float>(),
          (row_rad * towards.cross(across)).cast<float>()};
}

/// Points with sights, voxel by voxel.
struct SampledSurface {
  double voxel_m = 0.1;
  double column_rad = 0.003, row_rad = 0.007;
  Eigen::Vector3d eye{0.0, 0.0, 0.0};
  PointSet points;

  void add(const Eigen::Vector3d& p, double intensity = 0.5) {
    const Eigen::Index last = points.position.cols();
    points.position.conservativeResize(Eigen::NoChange, last + 1);
    points.position.col(last) = p.cast<float>();
    points.intensity.push_back(static_cast<float>(intensity));
    points.sight.push_back(sight_of(eye, p, column_rad, row_rad));
  }
  /// Adds a point in the centre of each voxel of a wall x = x_m: y0 <= y < y1, z0 <= z < z1, every `rows`
  /// voxels.
  void add_wall(
      double x_m, double y0, double y1, double z0, double z1, double intensity = 0.5, int rows = 1) {
    const auto voxels = [&](double m) { return static_cast<int>(std::lround(m / voxel_m)); };
    for (int i = voxels(y0); i < voxels(y1); ++i) {
      for (int j = voxels(z0); j < voxels(z1); j += rows) {
        add({x_m, (i + 0.5) * voxel_m, (j + 0.5) * voxel_m}, intensity);
      }
    }
  }
};

}  // namespace simuli::test
