#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <sys/stat.h>

#include "io/base/file.hpp"
#include "io/log/log.hpp"
#include "io/picture/image.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::Scratch;

Lidar some_lidar() {
  Lidar lidar;
  lidar.name = "top";
  lidar.rows = {{0.1, 0, 0, 0, 0}, {0.0, 0, 0, 0, 0}, {-0.1, 0, 0, 0, 0}};
  lidar.columns = 50;
  lidar.azimuth_first = 3.0;
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.spin = SpinDirection::kClockwise;
  lidar.range_max = 100.0;
  return lidar;
}

Sweep some_sweep(const Lidar& lidar) {
  Sweep sweep;
  sweep.rays = nominal_rays(lidar);
  for (std::size_t i = 0; i < lidar.ray_count(); ++i) {
    const bool returned = i % 5 != 0;
    sweep.range.push_back(returned ? 1.0F + 0.37F * static_cast<float>(i) : 0.0F);
    sweep.intensity.push_back(returned ? static_cast<float>(i % 11) / 11.0F : 0.0F);
  }
  return sweep;
}

TEST(SweepFile, KeepsEveryBit) {
  const Scratch scratch;
  const Lidar lidar = some_lidar();
  const Sweep sweep = some_sweep(lidar);
  write_sweep(scratch / "s.exr", sweep);
  const Sweep read = read_sweep(scratch / "s.exr", lidar);
  EXPECT_EQ(read.rays.rows, 3);
  EXPECT_EQ(read.rays.columns, 50);
  EXPECT_EQ(read.range, sweep.range);
  EXPECT_EQ(read.intensity, sweep.intensity);
  EXPECT_EQ(read.rays.azimuth, sweep.rays.azimuth);
  EXPECT_EQ(read.rays.elevation, sweep.rays.elevation);
  EXPECT_EQ(read.rays.time_fraction, sweep.rays.time_fraction);
}

TEST(SweepFile, KnowsNoDateAndNoPipe) {
  const Scratch scratch;
  const Lidar lidar = some_lidar();
  write_sweep(scratch / "a.exr", some_sweep(lidar));
  EXPECT_NE(read_file(scratch / "a.exr").find("1970:01:01 00:00:00"), std::string::npos);
  ASSERT_EQ(::mkfifo((scratch / "pipe.exr").c_str(), 0600), 0);
  expect_input_error([&] { (void)read_sweep(scratch / "pipe.exr", lidar); },
                     {"pipe.exr: file: found a pipe"});
}

TEST(SweepFile, RangesAreCorrectedOnReading) {
  const Scratch scratch;
  Lidar lidar = some_lidar();
  const Sweep sweep = some_sweep(lidar);
  write_sweep(scratch / "s.exr", sweep);
  lidar.rows[0].range_bias = 0.25;
  lidar.rows[2].range_bias = -0.5;
  const Sweep read = read_sweep(scratch / "s.exr", lidar);
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    const float bias = i < 50 ? 0.25F : i < 100 ? 0.0F : -0.5F;
    EXPECT_EQ(read.range[i], sweep.range[i] > 0.0F ? sweep.range[i] - bias : 0.0F) << i;
  }
  lidar.rows[1].range_bias = 30.0;  // unrealistic: more than the range of the row's first return, 19.87 m
  expect_input_error([&] { (void)read_sweep(scratch / "s.exr", lidar); }, {"range_m", "row 1", "30"});
}

TEST(SweepFile, RefusesAnotherSensorsGrid) {
  const Scratch scratch;
  Lidar lidar = some_lidar();
  write_sweep(scratch / "s.exr", some_sweep(lidar));
  lidar.columns = 51;
  expect_input_error([&] { (void)read_sweep(scratch / "s.exr", lidar); },
                     {"s.exr: rows x columns: found 3 x 50, allowed 3 x 51 of lidar top"});
}

TEST(SweepFile, RefusesBadValuesByChannelRowAndColumn) {
  const Scratch scratch;
  const Lidar lidar = some_lidar();
  const auto refuse = [&](auto&& spoil, const std::vector<std::string>& words) {
    Sweep sweep = some_sweep(lidar);
    spoil(sweep);
    expect_input_error([&] { write_sweep(scratch / "s.exr", sweep); }, words);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  refuse([&](Sweep& s) { s.range[62] = kNan; }, {"s.exr", "channel range_m: row 1, column 12", "found nan"});
  refuse([&](Sweep& s) { s.range[3] = kInf; }, {"channel range_m: row 0, column 3", "found inf"});
  refuse([&](Sweep& s) { s.range[149] = -1.0F; }, {"channel range_m: row 2, column 49", "found -1"});
  refuse([&](Sweep& s) { s.intensity[1] = 1.5F; }, {"channel intensity: row 0, column 1", "found 1.5"});
  refuse([&](Sweep& s) { s.intensity[5] = 0.5F; }, {"channel intensity: row 0, column 5", "range 0"});
  refuse([&](Sweep& s) { s.rays.azimuth[0] = kNan; }, {"channel azimuth_rad: row 0, column 0"});
  refuse([&](Sweep& s) { s.rays.elevation[0] = 2.0F; }, {"channel elevation_rad: row 0, column 0"});
  refuse([&](Sweep& s) { s.rays.time_fraction[0] = kNan; }, {"channel time_fraction: row 0, column 0"});
  refuse([&](Sweep& s) { s.intensity.pop_back(); }, {"channel intensity", "found 149 values", "allowed 150"});
  refuse([&](Sweep& s) { s.rays.rows = 0; }, {"rows x columns", "found 0 x 50"});
  EXPECT_TRUE(fs::is_empty(scratch.path()));
  expect_input_error([&] { write_sweep(scratch / "s.png", some_sweep(lidar)); }, {"s.png", ".exr"});
}

TEST(SweepFile, RefusesOtherChannelsAndTruncation) {
  const Scratch scratch;
  const Lidar lidar = some_lidar();
  write_image(scratch / "rgb.exr", Image(50, 3, 3));
  expect_input_error([&] { (void)read_sweep(scratch / "rgb.exr", lidar); },
                     {"rgb.exr", "channel range_m", "R, G, B"});
  write_sweep(scratch / "s.exr", some_sweep(lidar));
  const std::string bytes = read_file(scratch / "s.exr");
  const fs::path cut = scratch.file("cut.exr", bytes.substr(0, bytes.size() - 100));
  expect_input_error([&] { (void)read_sweep(cut, lidar); }, {"cut.exr", "found", "allowed"});
  expect_input_error([&] { (void)read_sweep(scratch / "none.exr", lidar); }, {"none.exr"});
  write_image(scratch / "a.png", Image(50, 3, 3));
  fs::rename(scratch / "a.png", scratch / "png.exr");
  expect_input_error([&] { (void)read_sweep(scratch / "png.exr", lidar); },
                     {"png.exr", "allowed those of OpenEXR"});
}

TEST(SweepFile, AllocatesNothingThatAHeaderClaims) {
  const Scratch scratch;
  const Lidar lidar = some_lidar();
  write_sweep(scratch / "s.exr", some_sweep(lidar));
  const std::string bytes = read_file(scratch / "s.exr");
  // After an attribute's name and type: its size, then its value.
  const auto with = [&](const std::string& attribute, std::size_t at, const std::string& value) {
    const std::size_t found = bytes.find(attribute);
    EXPECT_NE(found, std::string::npos);
    return std::string(bytes).replace(found + attribute.size() + at, value.size(), value);
  };
  using std::string_literals::operator""s;
  const fs::path longer = scratch.file("long.exr", with("channels\0chlist\0"s, 0, "stre"));
  expect_input_error([&] { (void)read_sweep(longer, lidar); }, {"long.exr", "1701999731 bytes"});
  // OpenEXR reads channels up to an empty name, regardless of the stated size.
  const fs::path shifted = scratch.file("shifted.exr", with("channels\0chlist\0"s, 0, "\x10"));
  expect_input_error([&] { (void)read_sweep(shifted, lidar); },
                     {"shifted.exr", "channels", "a wrong length"});
  const fs::path high = scratch.file("high.exr", with("dataWindow\0box2i\0"s, 16, "\xff\xff\xff\x7f"));
  expect_input_error([&] { (void)read_sweep(high, lidar); }, {"high.exr", "2147483648 pixels a side"});
  expect_input_error([&] { (void)read_image(high); }, {"high.exr", "2147483648 pixels a side"});
}

}  // namespace
}  // namespace simuli
