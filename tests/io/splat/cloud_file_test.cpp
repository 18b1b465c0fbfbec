#include "io/splat/cloud_file.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <string>

#include "io/base/file.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

using test::expect_input_error;
using test::Scratch;

PointCloud small_cloud() {
  PointCloud cloud;
  cloud.columns = {"x", "y", "z", "intensity"};
  cloud.values.resize(2, 4);
  cloud.values << 1.0F, 2.0F, 3.0F, 0.5F, -4.0F, 5.5F, 6.0F, 0.25F;
  return cloud;
}

template <class T>
T value_at(const std::string& bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

TEST(CloudFile, PcdHasItsHeaderAndRows) {
  const Scratch scratch;
  write_point_cloud(scratch / "a.pcd", small_cloud());
  const std::string bytes = read_file(scratch / "a.pcd");
  EXPECT_NE(
      bytes.find("FIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"),
      std::string::npos);
  const std::size_t data = bytes.find("DATA binary\n") + 12;
  ASSERT_EQ(bytes.size(), data + 32);
  EXPECT_EQ(value_at<float>(bytes, data + 16), -4.0F);
}

TEST(CloudFile, NpzHoldsArrays) {
  const Scratch scratch;
  write_point_cloud(scratch / "a.npz", small_cloud());
  const std::string bytes = read_file(scratch / "a.npz");
  const std::size_t xyz = bytes.find("xyz.npy");
  EXPECT_EQ(bytes.compare(xyz + 7, 6, "\x93NUMPY"), 0);
  EXPECT_NE(bytes.find("'shape': (2, 3), "), std::string::npos);
  EXPECT_NE(bytes.find("'shape': (2,), "), std::string::npos);
  EXPECT_EQ(value_at<float>(bytes, xyz + 7 + 128 + 12),
            -4.0F);  // the header's size is a multiple of 64 bytes
  EXPECT_EQ(bytes.substr(bytes.size() - 22, 4), "PK\x05\x06");
}

/// Coordinates whose float resolution is coarser than a millimetre, with counts.
PointCloud far_cloud() {
  PointCloud cloud;
  cloud.columns = {"x", "y", "z", "time", "ring"};
  cloud.types = {
      ColumnType::kDouble, ColumnType::kDouble, ColumnType::kDouble, ColumnType::kFloat, ColumnType::kUint16};
  cloud.values.resize(2, 5);
  cloud.values << 1.0, 2.0, 3.0, 0.05, 7.0, 524288.001, 5.0, 6.0, -0.01, 65535.0;
  return cloud;
}

TEST(CloudFile, KeepsTheTypesOfColumns) {
  const Scratch scratch;
  constexpr std::size_t kPoint = 3 * 8 + 4 + 2;
  const auto expect_second = [](const std::string& bytes, std::size_t at) {
    EXPECT_EQ(value_at<double>(bytes, at), 524288.001);
    EXPECT_EQ(value_at<float>(bytes, at + 24), -0.01F);
    EXPECT_EQ(value_at<std::uint16_t>(bytes, at + 28), 65535);
  };
  write_point_cloud(scratch / "a.pcd", far_cloud());
  const std::string pcd = read_file(scratch / "a.pcd");
  EXPECT_NE(pcd.find("FIELDS x y z time ring\nSIZE 8 8 8 4 2\nTYPE F F F F U\n"), std::string::npos);
  const std::size_t pcd_data = pcd.find("DATA binary\n") + 12;
  ASSERT_EQ(pcd.size(), pcd_data + 2 * kPoint);
  expect_second(pcd, pcd_data + kPoint);
  write_point_cloud(scratch / "a.ply", far_cloud());
  const std::string ply = read_file(scratch / "a.ply");
  EXPECT_NE(ply.find("property double z\nproperty float time\nproperty ushort ring\nend_header\n"),
            std::string::npos);
  expect_second(ply, ply.size() - kPoint);
  write_point_cloud(scratch / "a.npz", far_cloud());
  const std::string npz = read_file(scratch / "a.npz");
  EXPECT_NE(npz.find("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }"), std::string::npos);
  EXPECT_EQ(value_at<double>(npz, npz.find("xyz.npy") + 7 + 128 + 24), 524288.001);
  const std::size_t ring = npz.find("ring.npy");
  EXPECT_NE(npz.find("'<u2'", ring), std::string::npos);
  EXPECT_EQ(value_at<std::uint16_t>(npz, ring + 8 + 128 + 2), 65535);
}

TEST(CloudFile, RefusesWhatAColumnDoesNotHold) {
  const Scratch scratch;
  const auto refused = [&](const PointCloud& bad, const std::vector<std::string>& words) {
    expect_input_error([&] { write_point_cloud(scratch / "a.pcd", bad); }, words);
  };
  PointCloud bad = far_cloud();
  for (const double ring : {-1.0, 0.5, 65536.0}) {
    bad.values(1, 4) = ring;
    refused(bad, {"vertex 1: ring", "0 to 65535"});
  }
  bad = far_cloud();
  bad.values(0, 3) = 1e39;
  refused(bad, {"vertex 0: time"});
  bad = far_cloud();
  bad.types.pop_back();
  refused(bad, {"4 types for 5 columns"});
}

TEST(CloudFile, RefusesWhatNoFormatHolds) {
  const Scratch scratch;
  expect_input_error([&] { write_point_cloud(scratch / "a.las", small_cloud()); }, {".ply, .pcd or .npz"});
  PointCloud bad = small_cloud();
  bad.values(1, 3) = NAN;
  for (const char* name : {"a.ply", "a.pcd", "a.npz"}) {
    expect_input_error([&] { write_point_cloud(scratch / name, bad); }, {name, "vertex 1: intensity"});
    EXPECT_FALSE(std::filesystem::exists(scratch / name));
  }
}

}  // namespace
}  // namespace simuli
