#include "host/core/scene/particle_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace simuli {
namespace {

constexpr int kAxisBits = 21;  // three of them in a word

/// Spreads the lowest 21 bits of x with two zeros between them.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32U) & 0x001f00000000ffffU;
  x = (x | x << 16U) & 0x001f0000ff0000ffU;
  x = (x | x << 8U) & 0x100f00f00f00f00fU;
  x = (x | x << 4U) & 0x10c30c30c30c30c3U;
  return (x | x << 2U) & 0x1249249249249249U;
}

std::uint64_t cell_of(float position_m) {
  constexpr float kHalf = 1U << (kAxisBits - 1);
  const float cell = std::floor(position_m * kCoherentCellsPerMetre) + kHalf;
  // NaN fails the comparison.
  if (!(cell > 0.0F)) return 0;
  return static_cast<std::uint64_t>(std::min(cell, 2.0F * kHalf - 1.0F));
}

}  // namespace

GaussianSet subset(const GaussianSet& set, const std::vector<Eigen::Index>& kept) {
  GaussianSet out(set.kind, set.sh_degree, static_cast<Eigen::Index>(kept.size()));
  out.params = set.params(kept, Eigen::all);
  if (!set.actor.empty()) {
    for (const Eigen::Index i : kept) out.actor.push_back(set.actor[static_cast<std::size_t>(i)]);
  }
  return out;
}

std::uint64_t coherent_code(const Eigen::RowVector3f& mean) {
  return spread(cell_of(mean.x())) | spread(cell_of(mean.y())) << 1U | spread(cell_of(mean.z())) << 2U;
}

std::vector<Eigen::Index> coherent_order(const GaussianSet& set) {
  struct SortKey {
    std::uint32_t actor;
    std::uint64_t code;
    [[nodiscard]] auto operator<=>(const SortKey&) const = default;
  };
  std::vector<SortKey> keys(static_cast<std::size_t>(set.size()));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i] = {set.actor.empty() ? 0U : set.actor[i],
               coherent_code(set.mean().row(static_cast<Eigen::Index>(i)))};
  }
  std::vector<Eigen::Index> order(keys.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  if (std::is_sorted(keys.begin(), keys.end())) return order;
  std::stable_sort(order.begin(), order.end(), [&keys](Eigen::Index a, Eigen::Index b) {
    return keys[static_cast<std::size_t>(a)] < keys[static_cast<std::size_t>(b)];
  });
  return order;
}

GaussianSet in_coherent_order(GaussianSet set) {
  const std::vector<Eigen::Index> order = coherent_order(set);
  if (std::is_sorted(order.begin(), order.end())) return set;
  // One parameter at a time, so that large sets are never in memory twice.
  for (Eigen::Index row = 0; row < set.params.cols(); ++row) {
    set.params.col(row) = set.params.col(row)(order).eval();
  }
  if (!set.actor.empty()) {
    std::vector<std::uint32_t> actor;
    actor.reserve(order.size());
    for (const Eigen::Index i : order) actor.push_back(set.actor[static_cast<std::size_t>(i)]);
    set.actor = std::move(actor);
  }
  return set;
}

Scene in_coherent_order(Scene scene) {
  scene.camera = in_coherent_order(std::move(scene.camera));
  scene.lidar = in_coherent_order(std::move(scene.lidar));
  return scene;
}

}  // namespace simuli
