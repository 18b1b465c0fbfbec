#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace simuli {

/// Type of a cloud's column in files: float32, float64, unsigned 16-bit.
enum class ColumnType { kFloat, kDouble, kUint16 };

/// A point cloud: x y z (m), intensity in [0, 1], and other named columns.
struct PointCloud {
  std::vector<std::string> columns;                                               // at least "x", "y", "z"
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;  // [N, columns]
  std::vector<ColumnType> types = {};  // [columns]; empty: all kFloat

  [[nodiscard]] ColumnType type(std::size_t column) const {
    return types.empty() ? ColumnType::kFloat : types[column];
  }
};

}  // namespace simuli
