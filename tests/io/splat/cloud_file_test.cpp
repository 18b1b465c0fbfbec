#include "io/splat/cloud_file.hpp"

#include <cmath>
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

float float_at(const std::string& bytes, std::size_t at) {
  float value = NAN;
  std::memcpy(&value, bytes.data() + at, 4);
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
  EXPECT_EQ(float_at(bytes, data + 16), -4.0F);
}

TEST(CloudFile, NpzHoldsArrays) {
  const Scratch scratch;
  write_point_cloud(scratch / "a.npz", small_cloud());
  const std::string bytes = read_file(scratch / "a.npz");
  const std::size_t xyz = bytes.find("xyz.npy");
  EXPECT_EQ(bytes.compare(xyz + 7, 6, "\x93NUMPY"), 0);
  EXPECT_NE(bytes.find("'shape': (2, 3), "), std::string::npos);
  EXPECT_NE(bytes.find("'shape': (2,), "), std::string::npos);
  EXPECT_EQ(float_at(bytes, xyz + 7 + 128 + 12), -4.0F);  // the header takes a multiple of 64 bytes
  EXPECT_EQ(bytes.substr(bytes.size() - 22, 4), "PK\x05\x06");
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
