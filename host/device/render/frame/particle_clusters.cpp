#include "host/device/render/frame/particle_clusters.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "cl/shared/cluster.h"
#include "host/device/runtime/kernel.hpp"

namespace simuli {
namespace {

/// Whether a particle fulfils the assumptions of the bounds' proof (METHOD section 4). Comparisons are
/// positive, so that NaN fails.
bool is_bounded(const GaussianSet& set, Eigen::Index i) {
  constexpr float kFarthest_m = 1e15F, kLogScale = 30.0F, kSpread = 18.0F, kLogit = 1e30F;
  const auto scale = set.log_scale().row(i);
  bool sound = std::abs(set.opacity_logit()(i)) < kLogit;
  for (Eigen::Index k = 0; k < 3; ++k) {
    sound = sound && std::abs(set.mean()(i, k)) < kFarthest_m && std::abs(scale(k)) < kLogScale;
  }
  return sound && scale.maxCoeff() - scale.minCoeff() < kSpread;
}

/// One value per bound.
using Bounds = std::array<float, SIM_CLUSTER_ROWS>;
constexpr Bounds kAround{0.0F, 0.0F, 0.0F, 1e30F, 0.0F, 80.0F, 0.0F, kNeverMerged};

/// Bounds of particles [first, last), which belong to one actor or to none.
Bounds bounds_of(const GaussianSet& set, Eigen::Index first, Eigen::Index last) {
  for (Eigen::Index i = first; i < last; ++i) {
    if (!is_bounded(set, i)) return kAround;
  }
  const auto means = set.mean().middleRows(first, last - first).cast<double>().eval();
  const Eigen::RowVector3f centre =
      (0.5 * (means.colwise().minCoeff() + means.colwise().maxCoeff())).cast<float>();
  const double radius = (means.rowwise() - centre.cast<double>()).rowwise().norm().maxCoeff();
  // Rotations of actors round by a few ulps of the coordinates.
  const double rounding = 4e-6 * (radius + centre.cast<double>().norm());
  return {centre.x(),
          centre.y(),
          centre.z(),
          static_cast<float>((radius + rounding) * (1.0 + 1e-6)),
          set.log_scale().middleRows(first, last - first).maxCoeff(),
          set.opacity_logit().segment(first, last - first).maxCoeff(),
          0.0F,
          kNeverMerged};
}

}  // namespace

ParticleClusters clusters_of(const GaussianSet& set, const DetailLevels* levels) {
  const Eigen::Index count = (set.size() + SIM_CLUSTER - 1) / SIM_CLUSTER;
  ParticleClusters out;
  out.stride = static_cast<std::uint32_t>(round_up(static_cast<std::size_t>(count), 16));
  out.bounds.resize(std::size_t{SIM_CLUSTER_ROWS} * out.stride, 0.0F);
  out.actor.resize(out.stride, 0);
  for (Eigen::Index c = 0; c < count; ++c) {
    const Eigen::Index first = c * SIM_CLUSTER, last = std::min(first + SIM_CLUSTER, set.size());
    Bounds bounds = kAround;
    if (set.actor.empty()) {
      bounds = bounds_of(set, first, last);
    } else {
      const auto begin = set.actor.begin() + first, end = set.actor.begin() + last;
      if (std::all_of(begin, end, [&](std::uint32_t actor) { return actor == *begin; })) {
        bounds = bounds_of(set, first, last);
        out.actor[static_cast<std::size_t>(c)] = *begin;
      }
    }
    if (levels != nullptr) {
      bounds[SIM_C_FROM] = *std::min_element(levels->from_m.begin() + first, levels->from_m.begin() + last);
      bounds[SIM_C_UNTIL] =
          *std::max_element(levels->until_m.begin() + first, levels->until_m.begin() + last);
    }
    for (std::size_t row = 0; row < bounds.size(); ++row) {
      out.bounds[row * out.stride + static_cast<std::size_t>(c)] = bounds[row];
    }
  }
  return out;
}

}  // namespace simuli
