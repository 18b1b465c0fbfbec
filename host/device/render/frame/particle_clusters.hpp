#pragma once
// Bounds of particle clusters (cl/shared/cluster.h), with which frames cull invisible clusters.
#include <cstdint>
#include <vector>

#include "host/core/scene/gaussians.hpp"
#include "host/device/render/levels/levels.hpp"

namespace simuli {

struct ParticleClusters {
  std::uint32_t stride = 0;          // clusters, rounded up to 16
  std::vector<float> bounds;         // [SIM_CLUSTER_ROWS][stride]
  std::vector<std::uint32_t> actor;  // [stride]: actor of all particles of a cluster, else 0
};

/// Returns the bounds of a set's clusters. Clusters without valid bounds get a ball that contains every sensor:
/// clusters with particles of several actors, or of actors and the background, and clusters with a parameter
/// that is not finite or too large. levels: levels of detail of the set, if any.
[[nodiscard]] ParticleClusters clusters_of(const GaussianSet& set, const DetailLevels* levels = nullptr);

}  // namespace simuli
