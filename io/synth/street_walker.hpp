#pragma once
// The street's person: capsules that swing about hips, knees and shoulders, for io/synth/*.cpp.
#include <Eigen/Core>

#include "io/synth/street.hpp"

namespace simuli {

struct WalkerHit {
  bool hit = false;
  double range = 0.0;                                // m
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit, world
  Eigen::Vector3d albedo = Eigen::Vector3d::Zero();
  double reflectance = 0.0;
};

/// Returns the first intersection with the person at time_s of the ray from origin (world, m) along the unit
/// direction, before `range`.
[[nodiscard]] WalkerHit meet_walker(const StreetWalker& walker,
                                    const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& direction,
                                    double time_s,
                                    double range);

}  // namespace simuli
