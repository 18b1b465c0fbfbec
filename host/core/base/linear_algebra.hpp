#pragma once
// What Eigen has, compiled once: where a file names one of these itself, g++ takes 4 to 6 seconds longer for it.
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace simuli {

/// The least turn of `from` to the direction of `to`; of opposite directions any half turn. Neither may be zero.
[[nodiscard]] Eigen::Quaterniond turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// The pseudo-inverse of a symmetric matrix [n, n] without negative eigenvalues: those below n times the rounding of the
/// largest count as 0. Of a Matrix3d or a MatrixXd.
template <class Matrix>
[[nodiscard]] Matrix pseudo_inverse(const Matrix& symmetric);

}  // namespace simuli
