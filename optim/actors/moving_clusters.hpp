#pragma once
// Connected returns of a sweep of which many moved, each with a velocity that neighbouring sweeps agree with,
// and chains of them from sweep to sweep.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "optim/actors/motion_evidence.hpp"
#include "optim/actors/sweep_series.hpp"

namespace simuli {

struct MovingCluster {
  std::size_t sweep = 0;
  std::vector<std::uint32_t> points;  // of the sweep
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double time_s = 0.0;                                         // mean
  Eigen::Vector2d velocity_m_per_s = Eigen::Vector2d::Zero();  // over ground
  double agreement = 0.0;  // share of its points that neighbouring sweeps have where the velocity takes them
};

/// [sweeps][clusters]: returns that are not known to stand, connected over cells of 0.4 m, of which at least
/// 6 and a quarter move.
[[nodiscard]] std::vector<std::vector<MovingCluster>> moving_clusters(
    const SweepSeries& series, const std::vector<std::vector<Motion>>& motion);

/// Fills velocities and agreements.
void find_velocities(const SweepSeries& series, std::vector<std::vector<MovingCluster>>& clusters);

/// Clusters of one body, one per sweep, in order of time.
using ClusterChain = std::vector<const MovingCluster*>;
/// Chains of four and more clusters whose velocities lead from one to the next, over one missing sweep at
/// most; the ones with most points first.
[[nodiscard]] std::vector<ClusterChain> chains_of(const SweepSeries& series,
                                                  const std::vector<std::vector<MovingCluster>>& clusters);

}  // namespace simuli
