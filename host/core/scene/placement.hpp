#pragma once
// Transforms of particle sets, their extents, and LiDAR sets derived from camera sets.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/scene.hpp"

namespace simuli {

/// Transforms means, rotations, scales and SH coefficients to frame b, scaled by `scale`: p_b = b_from_a *
/// (scale * p_a). Also particles of actors, for which this is rarely useful. Throws Error{kUsage} for a scale
/// that is not above 0 and finite.
void transform(GaussianSet& set, const Pose& b_from_a, double scale = 1.0);

/// Returns the spherical harmonics of bands 0 to 3 in the direction from the sensor to a particle, as on the
/// device.
[[nodiscard]] Eigen::Matrix<double, 1, 16> sh_basis_at(const Eigen::Vector3d& direction);

/// Returns the extent of the particles, m: on each axis without one in 200 at either end, of those that are not
/// nearly transparent. Empty for a set without particles.
[[nodiscard]] Eigen::AlignedBox3d extent_of(const GaussianSet& set);

/// Returns a LiDAR set with the geometry of a camera set: every hit returns, with the luminance of the
/// particle's mean colour as intensity.
[[nodiscard]] GaussianSet lidar_of(const GaussianSet& camera);

}  // namespace simuli
