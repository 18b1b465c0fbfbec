#include "optim/actors/moving_clusters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "host/core/base/parallel.hpp"
#include "optim/init/points/point_tree.hpp"

namespace simuli {
namespace {

using ClusterCell = std::array<int, 2>;

constexpr double kCell_m = 0.4;
constexpr std::size_t kLeastMoving = 6;
constexpr double kLeastShare = 0.25;  // smallest share of moving points of a cluster

constexpr double kFastest_m_per_s = 45.0;
constexpr std::size_t kFarSweeps = 3;  // on either side, for velocity fits
constexpr std::size_t kSample = 96;  // points of a cluster used for fits
constexpr std::array<double, 8> kClusterReach_m{1.2, 1.2, 0.9, 0.9, 0.6, 0.6, 0.4, 0.4};
constexpr double kAgrees_m = 0.35;
constexpr std::size_t kRefined = 3;  // candidates of a cluster that are refined

constexpr double kLeastAgreement = 0.45;
constexpr double kSlowest_m_per_s = 0.5;  // slower velocities are not significant
constexpr double kLinkShare = 0.3;  // smallest share of common points of successive clusters
constexpr double kLink_m = 0.6;
constexpr std::size_t kShortestChain = 4;

ClusterCell cell_of(const Eigen::Vector3d& p, double side_m) {
  return {static_cast<int>(std::floor(p.x() / side_m)), static_cast<int>(std::floor(p.y() / side_m))};
}

MovingCluster cluster_of(const SeriesSweep& sweep, std::size_t index, std::vector<std::uint32_t> points) {
  MovingCluster out;
  out.sweep = index;
  for (const std::uint32_t i : points) {
    out.mean += sweep.position(i);
    out.time_s += sweep.time_s(i);
  }
  out.mean /= static_cast<double>(points.size());
  out.time_s /= static_cast<double>(points.size());
  out.points = std::move(points);
  return out;
}

/// Search trees of the points of every sweep.
class Trees {
 public:
  explicit Trees(const SweepSeries& series) {
    for (const SeriesSweep& sweep : series.sweeps) {
      views_.push_back(std::make_unique<CloudView>(CloudView{sweep.points}));
      trees_.push_back(
          std::make_unique<PointTree>(3, *views_.back(), nanoflann::KDTreeSingleIndexAdaptorParams(16)));
    }
    parallel_each(
        trees_.size(), [&](std::size_t i) { trees_[i]->buildIndex(); }, 1);
  }
  /// Returns the nearest point of a sweep within reach_m; no value in an empty sweep.
  [[nodiscard]] std::optional<std::uint32_t> nearest(std::size_t sweep,
                                                     const Eigen::Vector3d& p,
                                                     double reach_m) const {
    if (views_[sweep]->points.size() == 0) return std::nullopt;
    const std::array<float, 3> query{
        static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
    std::uint32_t index = 0;
    float square = 0.0F;
    if (trees_[sweep]->knnSearch(query.data(), 1, &index, &square) == 0) return std::nullopt;
    if (!(static_cast<double>(square) <= reach_m * reach_m)) return std::nullopt;
    return index;
  }

 private:
  std::vector<std::unique_ptr<CloudView>> views_;
  std::vector<std::unique_ptr<PointTree>> trees_;
};

/// Predicts a cluster's points in the surrounding sweeps by candidate velocities.
class VelocityFit {
 public:
  VelocityFit(const SweepSeries& series, const Trees& trees, const MovingCluster& cluster)
      : series_(series), trees_(trees), sweep_(series.sweeps[cluster.sweep]), index_(cluster.sweep) {
    const std::size_t step = std::max<std::size_t>(1, cluster.points.size() / kSample);
    for (std::size_t k = 0; k < cluster.points.size(); k += step) sample_.push_back(cluster.points[k]);
  }

  /// Share of the points that the sweeps within `far` confirm at their predicted positions.
  [[nodiscard]] double agreement(const Eigen::Vector2d& velocity, std::size_t far) const {
    std::size_t met = 0, all = 0;
    each_match(velocity,
               far,
               kAgrees_m,
               [&](double /*after_s*/, const Eigen::Vector3d* found, const Eigen::Vector3d&) {
                 ++all;
                 met += found != nullptr ? 1U : 0U;
               });
    return all > 0 ? static_cast<double>(met) / static_cast<double>(all) : 0.0;
  }

  [[nodiscard]] Eigen::Vector2d refined(Eigen::Vector2d velocity) const {
    for (const double reach_m : kClusterReach_m) {
      Eigen::Vector2d pulled = Eigen::Vector2d::Zero();
      double weight = 0.0;
      each_match(velocity,
                 kFarSweeps,
                 reach_m,
                 [&](double after_s, const Eigen::Vector3d* found, const Eigen::Vector3d& expected) {
                   if (found == nullptr) return;
                   pulled += after_s * (*found - expected).head<2>();
                   weight += after_s * after_s;
                 });
      if (weight > 0.0) velocity += pulled / weight;
    }
    return velocity;
  }

 private:
  /// Calls take(after_s, found or nullptr, expected) for each point and sweep.
  template <class F>
  void each_match(const Eigen::Vector2d& velocity, std::size_t far, double reach_m, const F& take) const {
    const std::size_t first = index_ > far ? index_ - far : 0;
    const std::size_t end = std::min(index_ + far + 1, series_.sweeps.size());
    for (std::size_t other = first; other < end; ++other) {
      if (other == index_) continue;
      const SeriesSweep& there = series_.sweeps[other];
      for (const std::uint32_t i : sample_) {
        const Eigen::Vector3d p = sweep_.position(i);
        double after_s = there.middle_s() - sweep_.middle_s();
        Eigen::Vector3d expected = p;
        expected.head<2>() += after_s * velocity;
        const auto nearest = trees_.nearest(other, expected, reach_m + 1.0);
        if (nearest) {  // at its own time; the search used the middle of the sweep
          after_s = there.time_s(*nearest) - sweep_.time_s(i);
          expected = p;
          expected.head<2>() += after_s * velocity;
        }
        const auto found = nearest ? trees_.nearest(other, expected, reach_m) : std::nullopt;
        const Eigen::Vector3d at = found ? there.position(*found) : Eigen::Vector3d::Zero();
        take(after_s, found ? &at : nullptr, expected);
      }
    }
  }

  const SweepSeries& series_;
  const Trees& trees_;
  const SeriesSweep& sweep_;
  std::size_t index_;
  std::vector<std::uint32_t> sample_;
};

void find_velocity(const SweepSeries& series,
                   const Trees& trees,
                   const std::vector<std::vector<MovingCluster>>& clusters,
                   MovingCluster& cluster) {
  const VelocityFit fit(series, trees, cluster);
  std::vector<std::pair<double, Eigen::Vector2d>> candidates;
  for (const std::size_t step : {std::size_t{1}, std::size_t{2}}) {
    for (const std::size_t other : {cluster.sweep - step, cluster.sweep + step}) {
      if (other >= clusters.size()) continue;  // also below 0
      for (const MovingCluster& to : clusters[other]) {
        const Eigen::Vector2d velocity = (to.mean - cluster.mean).head<2>() / (to.time_s - cluster.time_s);
        if (!(velocity.norm() < kFastest_m_per_s)) continue;
        candidates.emplace_back(fit.agreement(velocity, 1), velocity);
      }
    }
  }
  std::stable_sort(
      candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  candidates.resize(std::min(candidates.size(), kRefined));
  for (const auto& [first, start] : candidates) {
    const Eigen::Vector2d velocity = fit.refined(start);
    const double agreement = fit.agreement(velocity, kFarSweeps);
    if (!(agreement > cluster.agreement)) continue;
    cluster.agreement = agreement;
    cluster.velocity_m_per_s = velocity;
  }
}

bool is_sure(const MovingCluster& c) {
  return c.agreement >= kLeastAgreement && c.velocity_m_per_s.norm() >= kSlowest_m_per_s;
}

/// Share of a's points that b has at the positions predicted by a's velocity.
double link_share(const SweepSeries& series, const MovingCluster& a, const MovingCluster& b) {
  if ((a.velocity_m_per_s - b.velocity_m_per_s).norm() > std::max(1.5, 0.3 * a.velocity_m_per_s.norm()))
    return 0.0;
  const double after_s = b.time_s - a.time_s;
  const Eigen::Vector2d by = 0.5 * after_s * (a.velocity_m_per_s + b.velocity_m_per_s);
  std::map<ClusterCell, bool> cells;
  for (const std::uint32_t i : b.points) {
    const ClusterCell middle = cell_of(series.sweeps[b.sweep].position(i), kLink_m);
    for (int k = 0; k < 9; ++k) cells[{middle[0] + k % 3 - 1, middle[1] + k / 3 - 1}] = true;
  }
  std::size_t met = 0;
  for (const std::uint32_t i : a.points) {
    Eigen::Vector3d p = series.sweeps[a.sweep].position(i);
    p.head<2>() += by;
    met += cells.contains(cell_of(p, kLink_m)) ? 1U : 0U;
  }
  return static_cast<double>(met) / static_cast<double>(a.points.size());
}

}  // namespace

std::vector<std::vector<MovingCluster>> moving_clusters(const SweepSeries& series,
                                                        const std::vector<std::vector<Motion>>& motion) {
  std::vector<std::vector<MovingCluster>> out(series.sweeps.size());
  for (std::size_t s = 0; s < series.sweeps.size(); ++s) {
    std::map<ClusterCell, std::vector<std::uint32_t>> cells;
    for (std::size_t i = 0; i < motion[s].size(); ++i) {
      if (motion[s][i] == Motion::kStands) continue;
      cells[cell_of(series.sweeps[s].position(i), kCell_m)].push_back(static_cast<std::uint32_t>(i));
    }
    std::map<ClusterCell, bool> done;
    for (const auto& [start, unused] : cells) {
      if (done[start]) continue;
      done[start] = true;
      std::vector<ClusterCell> open{start};
      std::vector<std::uint32_t> members;
      while (!open.empty()) {
        const ClusterCell cell = open.back();
        open.pop_back();
        const std::vector<std::uint32_t>& here = cells.at(cell);
        members.insert(members.end(), here.begin(), here.end());
        for (int k = 0; k < 9; ++k) {
          const ClusterCell next{cell[0] + k % 3 - 1, cell[1] + k / 3 - 1};
          if (!cells.contains(next) || done[next]) continue;
          done[next] = true;
          open.push_back(next);
        }
      }
      const auto moving = static_cast<std::size_t>(std::count_if(
          members.begin(), members.end(), [&](std::uint32_t i) { return motion[s][i] == Motion::kMoves; }));
      if (moving < kLeastMoving ||
          static_cast<double>(moving) < kLeastShare * static_cast<double>(members.size()))
        continue;
      std::sort(members.begin(), members.end());
      out[s].push_back(cluster_of(series.sweeps[s], s, std::move(members)));
    }
  }
  return out;
}

void find_velocities(const SweepSeries& series, std::vector<std::vector<MovingCluster>>& clusters) {
  const Trees trees(series);
  std::vector<MovingCluster*> all;
  for (std::vector<MovingCluster>& of_sweep : clusters) {
    for (MovingCluster& cluster : of_sweep) all.push_back(&cluster);
  }
  parallel_each(
      all.size(), [&](std::size_t i) { find_velocity(series, trees, clusters, *all[i]); }, 2);
}

std::vector<ClusterChain> chains_of(const SweepSeries& series,
                                    const std::vector<std::vector<MovingCluster>>& clusters) {
  std::map<const MovingCluster*, const MovingCluster*> next, before;
  for (const std::size_t step : {std::size_t{1}, std::size_t{2}}) {
    for (std::size_t s = 0; s + step < clusters.size(); ++s) {
      Interruption::ask();
      struct Link {
        double share;
        const MovingCluster *from, *to;
      };
      std::vector<Link> links;
      for (const MovingCluster& a : clusters[s]) {
        if (!is_sure(a) || next.contains(&a)) continue;
        for (const MovingCluster& b : clusters[s + step]) {
          if (!is_sure(b) || before.contains(&b)) continue;
          const double share = std::min(link_share(series, a, b), link_share(series, b, a));
          if (share >= kLinkShare) links.push_back({share, &a, &b});
        }
      }
      std::stable_sort(
          links.begin(), links.end(), [](const Link& a, const Link& b) { return a.share > b.share; });
      for (const Link& link : links) {
        if (next.contains(link.from) || before.contains(link.to)) continue;
        next[link.from] = link.to;
        before[link.to] = link.from;
      }
    }
  }
  std::vector<std::pair<std::size_t, ClusterChain>> found;
  for (const std::vector<MovingCluster>& of_sweep : clusters) {
    for (const MovingCluster& cluster : of_sweep) {
      if (before.contains(&cluster) || !next.contains(&cluster)) continue;
      ClusterChain chain{&cluster};
      std::size_t points = cluster.points.size();
      for (auto at = next.find(&cluster); at != next.end(); at = next.find(at->second)) {
        chain.push_back(at->second);
        points += at->second->points.size();
      }
      if (chain.size() >= kShortestChain) found.emplace_back(points, std::move(chain));
    }
  }
  std::stable_sort(
      found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<ClusterChain> chains;
  for (auto& [points, chain] : found) chains.push_back(std::move(chain));
  return chains;
}

}  // namespace simuli
