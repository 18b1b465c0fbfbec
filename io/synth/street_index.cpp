// Bounding-box tree for rays in streets with many solids.
#include <algorithm>
#include <array>

#include "io/synth/street_world.hpp"

namespace simuli {
namespace {

using Eigen::Vector3d;

constexpr std::uint32_t kInLeaf = 4;
/// Boxes are enlarged by more than rounding errors, so that no intersection is missed.
constexpr double kSlack_m = 1e-6;

/// Whether the ray intersects the box up to `range`.
bool crosses(const Vector3d& low,
             const Vector3d& high,
             const Vector3d& origin,
             const Vector3d& inverse,
             double range) {
  const Vector3d a = (low - origin).cwiseProduct(inverse), b = (high - origin).cwiseProduct(inverse);
  const double enter = std::max(a.cwiseMin(b).maxCoeff(), 0.0);
  return enter <= std::min(a.cwiseMax(b).minCoeff(), range);
}

}  // namespace

StreetIndex::StreetIndex(const std::vector<StreetSolid>& solids) : order_(solids.size()) {
  for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<std::uint32_t>(i);
  nodes_.reserve(order_.size());
  if (!order_.empty()) part(solids, 0, static_cast<std::uint32_t>(order_.size()));
}

void StreetIndex::part(const std::vector<StreetSolid>& solids, std::uint32_t first, std::uint32_t count) {
  const std::size_t own = nodes_.size();
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  Vector3d low_middle = low, high_middle = high;
  const auto middle = [&](std::uint32_t i) -> Vector3d { return 0.5 * (solids[i].low + solids[i].high); };
  for (std::uint32_t i = first; i < first + count; ++i) {
    const StreetSolid& solid = solids[order_[i]];
    low = low.cwiseMin(solid.low);
    high = high.cwiseMax(solid.high);
    low_middle = low_middle.cwiseMin(middle(order_[i]));
    high_middle = high_middle.cwiseMax(middle(order_[i]));
  }
  const Vector3d slack = Vector3d::Constant(kSlack_m);
  nodes_.push_back({low - slack, high + slack, first, count, 0});
  if (count <= kInLeaf) return;
  int axis = 0;
  (high_middle - low_middle).maxCoeff(&axis);
  // Sorted by centre, then by index: the same tree on every platform.
  const auto begin = order_.begin() + first;
  const std::uint32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    const double at_a = middle(a)[axis], at_b = middle(b)[axis];
    return at_a != at_b ? at_a < at_b : a < b;
  });
  part(solids, first, half);
  nodes_[own].first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[own].count = 0;
  nodes_[own].axis = axis;
  part(solids, first + half, count - half);
}

const StreetSolid* StreetIndex::meet(const std::vector<StreetSolid>& solids,
                                     const Vector3d& origin,
                                     const Vector3d& direction,
                                     const Vector3d& inverse,
                                     StreetCrossing& nearest) const {
  if (nodes_.empty()) return nullptr;
  // Limits inverses, because infinity times zero is NaN for a face that contains the ray's start.
  constexpr double kLargest = 1e200;
  const Vector3d bounded = inverse.cwiseMax(-kLargest).cwiseMin(kLargest);
  const StreetSolid* met = nullptr;
  std::array<std::uint32_t, 64> waiting{};  // nodes to visit of a tree of 2^32 solids
  std::size_t count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const std::uint32_t at = waiting[--count];
    const Node& node = nodes_[at];
    if (!crosses(node.low, node.high, origin, bounded, nearest.range)) continue;
    if (node.count == 0) {  // nearer child first: its hits exclude the other
      const bool is_forward = direction[node.axis] >= 0.0;
      waiting[count++] = is_forward ? node.first : at + 1;
      waiting[count++] = is_forward ? at + 1 : node.first;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const StreetSolid& solid = solids[order_[i]];
      if (solid.shape(solid, origin, direction, inverse, nearest)) met = &solid;
    }
  }
  return met;
}

}  // namespace simuli
