#pragma once
// The track of one body as it is found: from a chain of clusters, aligned by what the laser measured, longer
// in time and larger in space as the sweeps allow.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "optim/actors/moving_clusters.hpp"
#include "optim/actors/sweep_series.hpp"

namespace simuli {

/// Scene frame. The body's frame stands on the ground, x forward.
struct BodyTrack {
  Actor actor;                      // the track alone; a key pose for each of `sweeps`
  std::vector<std::size_t> sweeps;  // strictly increasing
  Eigen::AlignedBox3d box;          // of the body, in its frame, m
  double above_ground_m = 0.0;      // of the frame's origin

  [[nodiscard]] std::size_t keys() const { return sweeps.size(); }
};

/// A return of a body.
struct BodyReturn {
  std::size_t key = 0;      // of the track
  std::uint32_t point = 0;  // of the sweep
  double time_s = 0.0;
  Eigen::Vector3d p_body = Eigen::Vector3d::Zero();
};

/// Returns that are taken already: [sweeps][points].
using TakenReturns = std::vector<std::vector<bool>>;

/// The track of a chain: positions by its velocities, heading along them.
[[nodiscard]] BodyTrack track_of(const SweepSeries& series, const ClusterChain& chain);

/// Those of one sweep inside `box` of a body at a pose that holds for all times of the sweep when the body
/// stands, and is carried along `actor`'s track when it drives.
[[nodiscard]] std::vector<BodyReturn> returns_of(const SweepSeries& series,
                                                 const BodyTrack& track,
                                                 std::size_t key,
                                                 const Eigen::AlignedBox3d& box,
                                                 const TakenReturns& taken);
[[nodiscard]] std::vector<BodyReturn> all_returns(const SweepSeries& series,
                                                  const BodyTrack& track,
                                                  const Eigen::AlignedBox3d& box,
                                                  const TakenReturns& taken);

/// Corrects the key poses by the returns in the box (actor_tracks.hpp) and makes the corrections part of
/// them; then turns the frame so that x is where the body drives to.
void align(const SweepSeries& series, BodyTrack& track, const TakenReturns& taken);

/// Sweeps' votes on points of the body, where it is when they look at it: `sweeps` of its keys that lie
/// evenly along its way. p_body: [3, N]; [N] votes.
[[nodiscard]] std::vector<PointVotes> votes_along(const SweepSeries& series,
                                                  const BodyTrack& track,
                                                  const PointSet& p_body,
                                                  std::size_t sweeps);

/// Follows the body into the sweeps before its first and behind its last key, moving or not, as long as what
/// is known of it is found there.
void grow_in_time(const SweepSeries& series, BodyTrack& track, const TakenReturns& taken);

/// Makes the box as large as what moves as the body does and hangs together with it.
void grow_in_space(const SweepSeries& series,
                   BodyTrack& track,
                   const std::vector<std::vector<Motion>>& motion,
                   const TakenReturns& taken);

}  // namespace simuli
