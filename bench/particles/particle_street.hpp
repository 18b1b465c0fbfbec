#pragma once
// Synthetic scenes of any size for measurements, generated from a seed.
#include <cstdint>

#include "host/core/base/pose.hpp"
#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// Order of the particles: coherent_order() as in trained scenes, or random, without coherent neighbours.
enum class StreetOrder { kCoherent, kShuffled };

/// Returns a street of `count` flattened Gaussians: road and pavements, two rows of facades, boxes and poles,
/// `length_m` long, scales of 3 to 15 cm, opacities 0.1 to 0.95. Equal arguments give equal bits.
[[nodiscard]] GaussianSet street_particles(SetKind kind,
                                           int sh_degree,
                                           Eigen::Index count,
                                           std::uint64_t seed,
                                           StreetOrder order = StreetOrder::kCoherent,
                                           double length_m = 180.0);

/// Returns the pose of a LiDAR half-way along the street, 1.9 m high.
[[nodiscard]] Pose world_from_street_lidar();

}  // namespace simuli
