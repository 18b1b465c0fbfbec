#pragma once
// Eigen functions that are compiled once: instantiating one of them in a file takes g++ 4 to 6 seconds.
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace simuli {

/// Returns the smallest rotation from `from` to the direction of `to`; for opposite directions any half
/// rotation. Neither may be zero.
[[nodiscard]] Eigen::Quaterniond turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Returns the pseudo-inverse of a symmetric positive semidefinite matrix [n, n]: eigenvalues below n times the
/// rounding of the largest count as 0. For Matrix3d and MatrixXd.
template <class Matrix>
[[nodiscard]] Matrix pseudo_inverse(const Matrix& symmetric);

}  // namespace simuli
