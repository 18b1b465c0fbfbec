#pragma once
// Particles elsewhere: moved, turned, scaled; where they are; and what LiDARs see of those that were made of
// pictures alone.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/scene.hpp"

namespace simuli {

/// Means, rotations, scales and SH coefficients in frame b, `scale` times as large: p_b = b_from_a * (scale *
/// p_a). Of particles of actors too: sets with them are better left where they are. Error{kUsage} for a
/// scale that is not above 0 and finite.
void transform(GaussianSet& set, const Pose& b_from_a, double scale = 1.0);

/// Spherical harmonics of bands 0 to 3 in a direction, as the device has them: what coefficients are weighted
/// with, which the direction from the sensor to a particle decides.
[[nodiscard]] Eigen::Matrix<double, 1, 16> sh_basis_at(const Eigen::Vector3d& direction);

/// Where the particles are, m: on each axis all but one in 200 at either end, of those that are not nearly
/// transparent. Empty for a set without particles.
[[nodiscard]] Eigen::AlignedBox3d extent_of(const GaussianSet& set);

/// A LiDAR set with the geometry of a camera set: every ray that meets it returns, as brightly as the
/// particles' mean colour is light.
[[nodiscard]] GaussianSet lidar_of(const GaussianSet& camera);

}  // namespace simuli
