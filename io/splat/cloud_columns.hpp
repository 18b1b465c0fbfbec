#pragma once
// Columns of clouds as bytes.
#include <bit>
#include <cstdint>
#include <string>

#include "host/core/base/point_cloud.hpp"
#include "io/base/bytes.hpp"

namespace simuli {

struct ColumnFormat {
  int bytes;
  const char* ply;
  const char* pcd;
  const char* numpy;
};

[[nodiscard]] inline const ColumnFormat& format_of(ColumnType type) {
  static constexpr ColumnFormat kFormats[] = {
      {4, "float", "F", "<f4"}, {8, "double", "F", "<f8"}, {2, "ushort", "U", "<u2"}};
  return kFormats[static_cast<std::size_t>(type)];
}

inline void append_value(std::string& to, ColumnType type, double value) {
  switch (type) {
    case ColumnType::kFloat:
      return append_little_endian(to, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
    case ColumnType::kDouble:
      return append_little_endian(to, std::bit_cast<std::uint64_t>(value), 8);
    case ColumnType::kUint16:
      return append_little_endian(to, static_cast<std::uint64_t>(value), 2);
  }
}

inline void append_point(std::string& to, const PointCloud& cloud, Eigen::Index row) {
  for (Eigen::Index c = 0; c < cloud.values.cols(); ++c) {
    append_value(to, cloud.type(static_cast<std::size_t>(c)), cloud.values(row, c));
  }
}

}  // namespace simuli
