#pragma once
// Reference line of a road through the positions of a drive.
#include <Eigen/Core>
#include <vector>

#include "host/core/base/pose.hpp"

namespace simuli {

/// A straight piece (curvature 0) or an arc.
struct RoadPiece {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();  // m
  double heading_rad = 0.0;                         // at the start, from x towards y
  double length_m = 0.0;
  double curvature_per_m = 0.0;  // positive: to the left

  /// Returns the position `along_m` after the start, also beyond both ends.
  [[nodiscard]] Eigen::Vector2d at(double along_m) const;
};

/// A position of the drive, and the arc length of the nearest point on the line.
struct RoadPosition {
  double s_m = 0.0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // m
};

struct RoadLine {
  std::vector<RoadPiece> pieces;     // each begins at the end of the previous one; at least one
  std::vector<RoadPosition> places;  // with non-decreasing s_m; at least one
  [[nodiscard]] double length_m() const;

  static constexpr double kTolerance_m = 0.02;     // largest distance from the positions
  static constexpr double kGrid_m = 1.0 / 1024.0;  // the length is slightly above a multiple of this
  static constexpr double kShortest_m = 10.0;      // of a drive without motion, along the rig's x axis
};

/// Returns the line through the rig's positions at which it was farther along than before; motion at standstill
/// and driving back and forth are left out. Pieces have common tangents unless no smooth line fits the
/// positions. `rig`: at least one pose, in time order; z is up.
[[nodiscard]] RoadLine road_line(const std::vector<Pose>& rig);

}  // namespace simuli
