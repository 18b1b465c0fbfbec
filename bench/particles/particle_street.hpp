#pragma once
// A scene of any size for measurements, made up of nothing but a seed.
#include <cstdint>

#include "host/core/base/pose.hpp"
#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// As a trained scene has them, in coherent_order(), or as they were drawn: no two neighbours belong
/// together.
enum class StreetOrder { kCoherent, kShuffled };

/// A street of `count` flattened Gaussians: road and pavements, two rows of facades, boxes and poles,
/// `length_m` long, scales of 3 to 15 cm, opacities 0.1 to 0.95. The same bits for the same arguments.
[[nodiscard]] GaussianSet street_particles(SetKind kind,
                                           int sh_degree,
                                           Eigen::Index count,
                                           std::uint64_t seed,
                                           StreetOrder order = StreetOrder::kCoherent,
                                           double length_m = 180.0);

/// Half-way down that street, 1.9 m up: a LiDAR.
[[nodiscard]] Pose world_from_street_lidar();

}  // namespace simuli
