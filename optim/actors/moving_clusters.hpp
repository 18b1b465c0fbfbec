#pragma once
// Connected returns of a sweep with many moving points, each with a velocity confirmed by neighbouring sweeps,
// and chains of such clusters over sweeps.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "optim/actors/motion_evidence.hpp"
#include "optim/actors/sweep_series.hpp"

namespace simuli {

struct MovingCluster {
  std::size_t sweep = 0;
  std::vector<std::uint32_t> points;  // indices in the sweep
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double time_s = 0.0;                                         // mean
  Eigen::Vector2d velocity_m_per_s = Eigen::Vector2d::Zero();  // over ground
  double agreement = 0.0;  // share of its points that neighbouring sweeps confirm at predicted positions
};

/// Returns [sweeps][clusters]: returns not classified as static, connected over cells of 0.4 m, with at least 6
/// points and a quarter of them moving.
[[nodiscard]] std::vector<std::vector<MovingCluster>> moving_clusters(
    const SweepSeries& series, const std::vector<std::vector<Motion>>& motion);

/// Computes velocities and agreements.
void find_velocities(const SweepSeries& series, std::vector<std::vector<MovingCluster>>& clusters);

/// Clusters of one body, one per sweep, in time order.
using ClusterChain = std::vector<const MovingCluster*>;
/// Returns chains of at least four clusters linked by their velocities, bridging at most one missing sweep;
/// chains with most points first.
[[nodiscard]] std::vector<ClusterChain> chains_of(const SweepSeries& series,
                                                  const std::vector<std::vector<MovingCluster>>& clusters);

}  // namespace simuli
