#pragma once
// The line along which a road lies, of the places that a drive took.
#include <Eigen/Core>
#include <vector>

#include "host/core/base/pose.hpp"

namespace simuli {

/// A straight piece (curvature 0) or an arc.
struct RoadPiece {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();  // m
  double heading_rad = 0.0;                         // there, from x towards y
  double length_m = 0.0;
  double curvature_per_m = 0.0;  // above 0: to the left

  /// Where it is `along_m` behind its start, also beyond its ends.
  [[nodiscard]] Eigen::Vector2d at(double along_m) const;
};

/// A place of the drive, and how far along the line the point is that is nearest to it.
struct RoadPosition {
  double s_m = 0.0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // m
};

struct RoadLine {
  std::vector<RoadPiece> pieces;  // each begins where the one before ends; at least one
  std::vector<RoadPosition> places;  // s_m does not fall; at least one
  [[nodiscard]] double length_m() const;

  static constexpr double kTolerance_m = 0.02;     // from its places
  static constexpr double kGrid_m = 1.0 / 1024.0;  // its length is just above a multiple of this
  static constexpr double kShortest_m = 10.0;      // of a drive that stood still, along the rig's x axis
};

/// The line through where the rig was, once it had gone farther along than ever before: what it did while it
/// stood, and the way back and forth again of a rig that reversed, is not in it. Pieces meet without a kink,
/// but where places lie as no smooth line does. `rig`: one pose at least, in order of time; z is up.
[[nodiscard]] RoadLine road_line(const std::vector<Pose>& rig);

}  // namespace simuli
