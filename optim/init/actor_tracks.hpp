#pragma once
// Tracks of actors made to agree with the laser: what it measured of an actor at all times shall lie on one
// and the same surface in the actor's frame.
#include <Eigen/Core>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// A return from an actor.
struct ActorReturn {
  double time_s = 0.0;  // its own
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
};

/// What is believed of a track, as standard deviations.
struct TrackPrior {
  double label_m = 0.3;  // of a key pose as recorded
  double label_rad = 0.05;
  double acceleration_m_per_s2 = 2.0;  // of the corrected track
  double turn_rad_per_s2 = 0.5;
};

/// Inverse covariance of the returns in a voxel of that side, as what a surface tells of where it is: nothing
/// along directions in which they fill the voxel, as a wall that slides along itself looks the same; what is
/// seen of it would pull it towards where the sensor is. sigma_m: standard deviation of a return.
[[nodiscard]] Eigen::Matrix3d surface_information(const Eigen::Matrix3d& covariance,
                                                  double sigma_m,
                                                  double voxel_m);

/// Fills the offsets (shift_m, turn_rad) of the actor's key poses from its returns: each return is drawn to
/// the normal distribution of those in its voxel of the actor's frame (Magnusson, "The three-dimensional
/// normal-distributions transform", 2009), Cauchy weights, Gauss-Newton over all key poses at once. Where
/// the returns say nothing the prior does. Left as it is: a track of fewer than two poses, or without
/// returns.
void register_track(Actor& actor, const std::vector<ActorReturn>& returns, const TrackPrior& prior = {});

}  // namespace simuli
