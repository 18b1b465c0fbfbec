#pragma once
// Bounds of clusters of particles (cl/shared/cluster.h), by which frames leave out what they cannot see.
#include <cstdint>
#include <vector>

#include "host/core/scene/gaussians.hpp"
#include "host/device/render/levels/levels.hpp"

namespace simuli {

struct ParticleClusters {
  std::uint32_t stride = 0;          // clusters, rounded up to 16
  std::vector<float> bounds;         // [SIM_CLUSTER_ROWS][stride]
  std::vector<std::uint32_t> actor;  // [stride]: the one that all particles of a cluster belong to, else 0
};

/// Clusters of which nothing is to be known are bounded by a ball that every sensor is in: such with
/// particles of several actors, or of some and the background, and such with a parameter that is not finite
/// or beyond all use. levels: those of the set, if it has any.
[[nodiscard]] ParticleClusters clusters_of(const GaussianSet& set, const DetailLevels* levels = nullptr);

}  // namespace simuli
