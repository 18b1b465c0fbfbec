#pragma once
// Registers actors' tracks to LiDAR returns: the returns of an actor at all times shall lie on one surface in
// the actor's frame.
#include <Eigen/Core>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// A return of an actor.
struct ActorReturn {
  double time_s = 0.0;  // time of the return
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
};

/// Prior of a track, as standard deviations.
struct TrackPrior {
  double label_m = 0.3;  // of a recorded key pose
  double label_rad = 0.05;
  double acceleration_m_per_s2 = 2.0;  // of the corrected track
  double turn_rad_per_s2 = 0.5;
};

/// Returns the inverse covariance of the returns in a voxel of that side, as the information of a surface about
/// its position: zero along directions in which the returns fill the voxel, because a wall looks the same when
/// it slides along itself, and its visible part would be pulled towards the sensor. sigma_m: standard deviation
/// of a return.
[[nodiscard]] Eigen::Matrix3d surface_information(const Eigen::Matrix3d& covariance,
                                                  double sigma_m,
                                                  double voxel_m);

/// Estimates the offsets (shift_m, turn_rad) of the actor's key poses from its returns: each return is
/// attracted to the normal distribution of the returns in its voxel of the actor's frame (Magnusson, "The
/// three-dimensional normal-distributions transform", 2009), with Cauchy weights and Gauss-Newton over all key
/// poses. The prior applies where returns give no information. Tracks with fewer than two poses or without
/// returns do not change.
void register_track(Actor& actor, const std::vector<ActorReturn>& returns, const TrackPrior& prior = {});

}  // namespace simuli
