#include "host/core/scene/visibility_sets.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace simuli {
namespace {

// Path length over which one visibility set fades into the next.
constexpr double kFade_m = 4.0;

double distance_to(const std::vector<Eigen::Vector3d>& path, const Eigen::Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector3d& from = path[i];
    const Eigen::Vector3d along = path[std::min(i + 1, path.size() - 1)] - from;
    const double length2 = along.squaredNorm();
    const double at = length2 > 0.0 ? std::clamp((p - from).dot(along) / length2, 0.0, 1.0) : 0.0;
    least = std::min(least, (p - from - at * along).norm());
  }
  return least;
}

}  // namespace

std::vector<double> visibility_shares(const std::vector<VisibilitySet>& visibility_sets, const Eigen::Vector3d& eye) {
  std::vector<double> shares;
  for (const VisibilitySet& visibility_set : visibility_sets) shares.push_back(distance_to(visibility_set.path_m, eye));
  if (shares.empty()) return shares;
  const double nearest = *std::min_element(shares.begin(), shares.end());
  const double fade_m = std::max(kFade_m, nearest);  // seen from a distance, sets differ little
  for (double& share : shares) share = std::max(1.0 - (share - nearest) / fade_m, 0.0);
  return shares;
}

std::size_t nearest_visibility_set(const std::vector<VisibilitySet>& visibility_sets, const Eigen::Vector3d& p_world) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < visibility_sets.size(); ++i) {
    const double distance = distance_to(visibility_sets[i].path_m, p_world);
    if (distance >= least) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

}  // namespace simuli
