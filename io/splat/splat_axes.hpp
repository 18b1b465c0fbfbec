#pragma once
// Conversion of splats to the axes of a format.
#include <Eigen/Geometry>

#include "host/core/scene/gaussians.hpp"
#include "io/splat/splat_file.hpp"

namespace simuli {

/// Returns the rotation from a model's axes to x forward, y left, z up.
[[nodiscard]] Eigen::Quaterniond level_from(SplatAxes axes);

/// x left, y up, z forward of glTF 2.0 (section 3.4), from x forward, y left, z up.
inline const Eigen::Quaterniond kGltfFromLevel{0.5, -0.5, -0.5, -0.5};

/// Returns the rotated set; unchanged for the identity.
[[nodiscard]] GaussianSet turned(const GaussianSet& set, const Eigen::Quaterniond& b_from_a);

/// Opacity and scale in the terms of these formats. Opacities of 0 and 1 and scales of 0, which have no logit
/// and no logarithm, become the nearest representable values.
[[nodiscard]] float opacity_of(float logit);
[[nodiscard]] float logit_of(float opacity);
[[nodiscard]] float log_scale_of(float scale_m);
/// Returns w, x, y, z of length 1.
[[nodiscard]] Eigen::Vector4f unit_rotation(const GaussianSet& set, Eigen::Index particle);

/// Throws the errors of validate(), and Error{kInput} for LiDAR sets, because these formats contain colours.
void need_camera_set(const GaussianSet& set, const std::string& file);

}  // namespace simuli
