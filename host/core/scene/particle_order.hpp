#pragma once
// Which particle stands where: neighbours in space are to be neighbours in memory, so that kernels which take
// particles by the vector or work-group find whole groups outside of a frame, and what a tile reads near by.
#include <cstdint>
#include <vector>

#include "host/core/scene/scene.hpp"

namespace simuli {

/// The particles at `kept`, in that order.
[[nodiscard]] GaussianSet subset(const GaussianSet& set, const std::vector<Eigen::Index>& kept);

inline constexpr float kCoherentCellsPerMetre = 16.0F;
/// Of the cell of 1/16 m that a place (m) is in, along a Morton curve; without its last 3 n bits that of the
/// cell 2^n times as large.
[[nodiscard]] std::uint64_t coherent_code(const Eigen::RowVector3f& mean);

/// The order along a Morton curve over cells of 1/16 m (G. M. Morton, 1966): the background's particles, then
/// each actor's, in whose frame the curve runs. Particles of one cell keep their order; those beyond 65 km,
/// or with a mean that is not a number, come with the cells at the rim.
[[nodiscard]] std::vector<Eigen::Index> coherent_order(const GaussianSet& set);

/// The set in that order; as it is when it is in it already. Of a scene both sets.
[[nodiscard]] GaussianSet in_coherent_order(GaussianSet set);
[[nodiscard]] Scene in_coherent_order(Scene scene);

}  // namespace simuli
