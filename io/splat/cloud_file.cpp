#include "io/splat/cloud_file.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>
#include <vector>
#include <zlib.h>

#include "host/base/error.hpp"
#include "io/base/bytes.hpp"
#include "io/base/file.hpp"

namespace simuli {
namespace {

void append_float(std::string& to, float value) {
  append_little_endian(to, std::bit_cast<std::uint32_t>(value), 4);
}

std::string pcd(const PointCloud& cloud) {
  const std::size_t columns = cloud.columns.size();
  const auto each = [columns](const char* word) {
    return fmt::format("{}", fmt::join(std::vector<const char*>(columns, word), " "));
  };
  const auto points = cloud.values.rows();
  std::string out = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n"
      "WIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      fmt::join(cloud.columns, " "),
      each("4"),
      each("F"),
      each("1"),
      points,
      points);
  for (Eigen::Index v = 0; v < points; ++v) {
    for (Eigen::Index c = 0; c < cloud.values.cols(); ++c) append_float(out, cloud.values(v, c));
  }
  return out;
}

/// An array of float32 as a .npy file, format 1.0.
std::string npy(const PointCloud& cloud, const std::vector<Eigen::Index>& columns) {
  const auto rows = cloud.values.rows();
  const std::string shape =
      columns.size() == 1 ? fmt::format("({},)", rows) : fmt::format("({}, {})", rows, columns.size());
  std::string header = fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': {}, }}", shape);
  constexpr std::size_t kFrame = 10, kAlignment = 64;  // magic, version and length; where the data start
  while ((kFrame + header.size() + 1) % kAlignment != 0) header.push_back(' ');
  header.push_back('\n');
  std::string out("\x93NUMPY\x01\x00", 8);
  append_little_endian(out, header.size(), 2);
  out += header;
  for (Eigen::Index v = 0; v < rows; ++v) {
    for (const Eigen::Index c : columns) append_float(out, cloud.values(v, c));
  }
  return out;
}

/// A zip archive of files that are stored as they are, the earliest date zip knows.
class Zip {
 public:
  void add(const std::string& name, const std::string& bytes, const std::string& file) {
    constexpr std::size_t kMost = 0xffffffffU;  // of the format without its extension
    if (out_.size() + bytes.size() > kMost) {
      throw_input_error(file, "size", "more than 4 GiB", "less, or .ply");
    }
    const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    std::string entry;                   // what the local header and the directory share
    append_little_endian(entry, 20, 2);  // version 2.0
    append_little_endian(entry, 0, 2);
    append_little_endian(entry, 0, 2);  // stored
    append_little_endian(entry, 0, 2);
    append_little_endian(entry, 0x21, 2);  // 1 January 1980
    append_little_endian(entry, crc, 4);
    append_little_endian(entry, bytes.size(), 4);
    append_little_endian(entry, bytes.size(), 4);
    append_little_endian(entry, name.size(), 2);
    append_little_endian(entry, 0, 2);
    directory_ += std::string("PK\x01\x02\x14\x00", 6) + entry;
    directory_.append(10, '\0');
    append_little_endian(directory_, out_.size(), 4);
    directory_ += name;
    out_ += "PK\x03\x04" + entry + name + bytes;
    ++count_;
  }
  [[nodiscard]] std::string finish() const {
    std::string end = "PK\x05\x06";
    append_little_endian(end, 0, 4);
    append_little_endian(end, count_, 2);
    append_little_endian(end, count_, 2);
    append_little_endian(end, directory_.size(), 4);
    append_little_endian(end, out_.size(), 4);
    append_little_endian(end, 0, 2);
    return out_ + directory_ + end;
  }

 private:
  std::string out_, directory_;
  std::size_t count_ = 0;
};

std::string npz(const PointCloud& cloud, const std::string& file) {
  Zip zip;
  std::vector<Eigen::Index> xyz;
  for (const char* name : {"x", "y", "z"}) {
    xyz.push_back(std::find(cloud.columns.begin(), cloud.columns.end(), name) - cloud.columns.begin());
  }
  zip.add("xyz.npy", npy(cloud, xyz), file);
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    const auto column = static_cast<Eigen::Index>(c);
    if (std::find(xyz.begin(), xyz.end(), column) != xyz.end()) continue;
    zip.add(cloud.columns[c] + ".npy", npy(cloud, {column}), file);
  }
  return zip.finish();
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
