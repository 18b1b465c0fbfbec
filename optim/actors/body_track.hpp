#pragma once
// The track of one body during the search: initialised from a chain of clusters, registered by its returns, and
// extended in time and space as far as the sweeps allow.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "optim/actors/moving_clusters.hpp"
#include "optim/actors/sweep_series.hpp"

namespace simuli {

/// A body in the scene frame. The body's frame stands on the ground, x forward.
struct BodyTrack {
  Actor actor;  // only its track; one key pose for each of `sweeps`
  std::vector<std::size_t> sweeps;  // strictly increasing
  Eigen::AlignedBox3d box;  // in the body's frame, m
  double above_ground_m = 0.0;  // height of the frame's origin

  [[nodiscard]] std::size_t keys() const { return sweeps.size(); }
};

/// A return of a body.
struct BodyReturn {
  std::size_t key = 0;      // of the track
  std::uint32_t point = 0;  // of the sweep
  double time_s = 0.0;
  Eigen::Vector3d p_body = Eigen::Vector3d::Zero();
};

/// Returns assigned to other bodies: [sweeps][points].
using TakenReturns = std::vector<std::vector<bool>>;

/// Returns the track of a chain: positions from its velocities, headings along them.
[[nodiscard]] BodyTrack track_of(const SweepSeries& series, const ClusterChain& chain);

/// Returns the returns of one sweep inside `box` of a body at a constant pose for a standing body, or moved
/// along `actor`'s track.
[[nodiscard]] std::vector<BodyReturn> returns_of(const SweepSeries& series,
                                                 const BodyTrack& track,
                                                 std::size_t key,
                                                 const Eigen::AlignedBox3d& box,
                                                 const TakenReturns& taken);
[[nodiscard]] std::vector<BodyReturn> all_returns(const SweepSeries& series,
                                                  const BodyTrack& track,
                                                  const Eigen::AlignedBox3d& box,
                                                  const TakenReturns& taken);

/// Corrects the key poses by the returns in the box (actor_tracks.hpp) and applies the corrections; then
/// rotates the frame so that x is the driving direction.
void align(const SweepSeries& series, BodyTrack& track, const TakenReturns& taken);

/// Votes of sweeps on points of the body at its pose at the time of observation, by `sweeps` of its keys evenly
/// spread along its path. p_body: [3, N]; returns [N] votes.
[[nodiscard]] std::vector<PointVotes> votes_along(const SweepSeries& series,
                                                  const BodyTrack& track,
                                                  const PointSet& p_body,
                                                  std::size_t sweeps);

/// Follows the body into the sweeps before its first and after its last key, moving or not, as long as its
/// known surface is found there.
void grow_in_time(const SweepSeries& series, BodyTrack& track, const TakenReturns& taken);

/// Enlarges the box to all connected points that move with the body.
void grow_in_space(const SweepSeries& series,
                   BodyTrack& track,
                   const std::vector<std::vector<Motion>>& motion,
                   const TakenReturns& taken);

}  // namespace simuli
