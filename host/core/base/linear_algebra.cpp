#include "host/core/base/linear_algebra.hpp"

#include <Eigen/Eigenvalues>
#include <limits>

namespace simuli {

Eigen::Quaterniond turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

template <class Matrix>
Matrix pseudo_inverse(const Matrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(symmetric);
  const auto& values = solver.eigenvalues();
  const double least = static_cast<double>(symmetric.rows()) * std::numeric_limits<double>::epsilon() *
                       values.cwiseAbs().maxCoeff();
  const auto inverse = values.unaryExpr([least](double v) { return v > least ? 1.0 / v : 0.0; });
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}
template Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& symmetric);
template Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& symmetric);

}  // namespace simuli
