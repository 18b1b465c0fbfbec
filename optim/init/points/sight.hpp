#pragma once
// Sampling density of a sensor at its returns.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "host/core/sensors/lidar_model.hpp"

namespace simuli {

/// The nearest observation of a point: its ray, and the directions of neighbouring rays in the sweep.
struct Sight {
  float range_m = std::numeric_limits<float>::infinity();  // +inf: no ray hit it
  Eigen::Vector3f towards = Eigen::Vector3f::Zero();       // unit, from the sensor to the point
  /// From this ray's direction to those of the next firing and of the next beam, rad; perpendicular to it.
  Eigen::Vector3f column_step = Eigen::Vector3f::Zero();
  Eigen::Vector3f row_step = Eigen::Vector3f::Zero();

  [[nodiscard]] bool is_known() const { return range_m < std::numeric_limits<float>::infinity(); }
  /// The same in other axes.
  [[nodiscard]] Sight turned(const Eigen::Quaternionf& to_from) const;
  /// From the point to the neighbours' intersection with the plane of that unit normal, m; incidence limited to
  /// kGrazing.
  [[nodiscard]] Eigen::Vector3f column_step_on(const Eigen::Vector3f& normal) const;
  [[nodiscard]] Eigen::Vector3f row_step_on(const Eigen::Vector3f& normal) const;

  static constexpr float kGrazing = 0.02F;  // cosine of the incidence
};

/// A total order: the nearest first, independent of insertion order.
[[nodiscard]] bool is_nearer(const Sight& a, const Sight& b);

/// Makes sights of a sensor's returns.
class SightMaker {
 public:
  explicit SightMaker(const LidarModel& lidar);
  /// Returns the sight of a ray that returned from range_m, in the axes of scene_from_lidar.
  [[nodiscard]] Sight of(const LidarRays& rays,
                         std::size_t ray,
                         float range_m,
                         const Eigen::Quaterniond& scene_from_lidar) const;

 private:
  std::size_t columns_ = 1;
  double column_step_rad_ = 0.0;
  std::vector<double> row_step_rad_;  // [rows]
};

}  // namespace simuli
