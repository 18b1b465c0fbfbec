#pragma once
// Spatial order of particles: neighbours in space are neighbours in memory, so that whole vectors or
// work-groups are outside a frame, and tiles read memory nearby.
#include <cstdint>
#include <vector>

#include "host/core/scene/scene.hpp"

namespace simuli {

/// Returns the particles at `kept`, in that order.
[[nodiscard]] GaussianSet subset(const GaussianSet& set, const std::vector<Eigen::Index>& kept);

inline constexpr float kCoherentCellsPerMetre = 16.0F;
/// Returns the Morton code of the 1/16 m cell of a position (m); without its last 3 n bits that of the cell 2^n
/// times as large.
[[nodiscard]] std::uint64_t coherent_code(const Eigen::RowVector3f& mean);

/// Returns the order along a Morton curve over cells of 1/16 m (G. M. Morton, 1966): background particles, then
/// each actor's in the actor's frame. Stable within a cell; particles beyond 65 km, or with a non-finite mean,
/// are in the outermost cells.
[[nodiscard]] std::vector<Eigen::Index> coherent_order(const GaussianSet& set);

/// Returns the set in that order, unchanged if it is sorted. For a scene both sets.
[[nodiscard]] GaussianSet in_coherent_order(GaussianSet set);
[[nodiscard]] Scene in_coherent_order(Scene scene);

}  // namespace simuli
