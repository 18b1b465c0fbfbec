#include "io/splat/cloud_file.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>
#include <vector>

#include "host/core/base/error.hpp"
#include "io/archive/npz.hpp"
#include "io/base/file.hpp"
#include "io/splat/cloud_columns.hpp"

namespace simuli {
namespace {

std::string pcd(const PointCloud& cloud) {
  std::vector<std::string> sizes, types;
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    const ColumnFormat& format = format_of(cloud.type(c));
    sizes.push_back(std::to_string(format.bytes));
    types.emplace_back(format.pcd);
  }
  const auto points = cloud.values.rows();
  std::string out = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n"
      "WIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      fmt::join(cloud.columns, " "),
      fmt::join(sizes, " "),
      fmt::join(types, " "),
      fmt::join(std::vector<const char*>(cloud.columns.size(), "1"), " "),
      points,
      points);
  for (Eigen::Index v = 0; v < points; ++v) append_point(out, cloud, v);
  return out;
}

std::string npz(const PointCloud& cloud, const std::string& file) {
  Npz arrays(file);
  const auto rows = static_cast<std::size_t>(cloud.values.rows());
  std::vector<std::size_t> xyz;
  ColumnType type = ColumnType::kFloat;  // the same for all three
  for (const char* name : {"x", "y", "z"}) {
    const auto found = std::find(cloud.columns.begin(), cloud.columns.end(), name);
    xyz.push_back(static_cast<std::size_t>(found - cloud.columns.begin()));
    if (cloud.type(xyz.back()) != ColumnType::kFloat) type = ColumnType::kDouble;
  }
  const auto bytes = [&](const std::vector<std::size_t>& columns, ColumnType as) {
    std::string data;
    for (Eigen::Index v = 0; v < cloud.values.rows(); ++v) {
      for (const std::size_t c : columns) {
        append_value(data, as, cloud.values(v, static_cast<Eigen::Index>(c)));
      }
    }
    return data;
  };
  arrays.add("xyz", format_of(type).numpy, {rows, 3}, bytes(xyz, type));
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    if (std::find(xyz.begin(), xyz.end(), c) != xyz.end()) continue;
    arrays.add(cloud.columns[c], format_of(cloud.type(c)).numpy, {rows}, bytes({c}, cloud.type(c)));
  }
  return arrays.finish();
}

}  // namespace

void write_point_cloud(const std::filesystem::path& file, const PointCloud& cloud) {
  const std::string extension = file.extension().string();
  if (extension == ".ply") return write_point_cloud_ply(file, cloud);
  validate(cloud, file.string());
  if (extension == ".pcd") return write_file_atomically(file, pcd(cloud));
  if (extension == ".npz") return write_file_atomically(file, npz(cloud, file.string()));
  throw_input_error(file.string(), "extension", '"' + extension + '"', ".ply, .pcd or .npz");
}

}  // namespace simuli
