#pragma once
// Splats in the axes that a format asks for.
#include <Eigen/Geometry>

#include "host/core/scene/gaussians.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {

/// From a model's axes to x forward, y left, z up.
[[nodiscard]] Eigen::Quaterniond level_from(SplatAxes axes);

/// x left, y up, z forward, as glTF 2.0 has it (section 3.4), from x forward, y left, z up.
inline const Eigen::Quaterniond kGltfFromLevel{0.5, -0.5, -0.5, -0.5};

/// The set turned; as it is where there is nothing to turn.
[[nodiscard]] GaussianSet turned(const GaussianSet& set, const Eigen::Quaterniond& b_from_a);

/// What all these formats hold of a particle beside its mean, in their terms. Opacities of 0 and 1, and
/// scales of 0, which have no logit and no logarithm, become the nearest that have.
[[nodiscard]] float opacity_of(float logit);
[[nodiscard]] float logit_of(float opacity);
[[nodiscard]] float log_scale_of(float scale_m);
/// w, x, y, z of length 1.
[[nodiscard]] Eigen::Vector4f unit_rotation(const GaussianSet& set, Eigen::Index particle);

/// Error{kInput} for what validate() refuses, and for LiDAR sets: these formats hold colours.
void need_camera_set(const GaussianSet& set, const std::string& file);

}  // namespace simuli
