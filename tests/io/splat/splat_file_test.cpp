#include "io/splat/splat_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <gtest/gtest.h>
#include <string>

#include "io/base/bytes.hpp"
#include "io/base/file.hpp"
#include "io/base/gzip.hpp"
#include "io/splat/ply.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/splat/some_set.hpp"

namespace simuli {
namespace {

using test::expect_input_error;
using test::Scratch;
using test::some_set;

/// Returns the angle between two rotations in rad.
float angle_between(const GaussianSet& a, const GaussianSet& b, Eigen::Index v) {
  const Eigen::Vector4f p = a.rotation().row(v).normalized(), q = b.rotation().row(v).normalized();
  return 2.0F * std::acos(std::min(1.0F, std::abs(p.dot(q))));
}

void expect_close(const GaussianSet& a, const GaussianSet& b, float mean_m, float turn_rad, float sh) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.sh_degree, b.sh_degree);
  EXPECT_LT((a.mean() - b.mean()).cwiseAbs().maxCoeff(), mean_m);
  EXPECT_LT((a.log_scale() - b.log_scale()).cwiseAbs().maxCoeff(), 0.5F / 16.0F + 1e-4F);
  for (Eigen::Index v = 0; v < a.size(); ++v) {
    EXPECT_LT(angle_between(a, b, v), turn_rad) << v;
    const auto opacity = [v](const GaussianSet& s) {
      return 1.0F / (1.0F + std::exp(-s.opacity_logit()(v)));
    };
    EXPECT_NEAR(opacity(a), opacity(b), 0.6F / 255.0F) << v;
  }
  const int higher = 3 * (sh_coefficients(a.sh_degree) - 1);
  EXPECT_LT((a.sh(0) - b.sh(0)).cwiseAbs().maxCoeff(), 0.5F / (255.0F * 0.15F) + 1e-4F);
  if (higher > 0) {
    EXPECT_LT((a.params.rightCols(higher) - b.params.rightCols(higher)).cwiseAbs().maxCoeff(), sh);
  }
}

TEST(Spz, ReadsWhatItWrote) {
  const Scratch scratch;
  for (const int degree : {0, 1, 2, 3}) {
    const GaussianSet set = some_set(degree, 300);
    write_spz(scratch / "a.spz", set);
    // A step of 1/4096 m; a component's step of 1/511 of sqrt(1/2).
    expect_close(read_splats(scratch / "a.spz"), set, 0.5F / 4096.0F + 1e-5F, 5e-3F, 0.5F / 128.0F + 1e-5F);
  }
  GaussianSet far = some_set(0, 2);
  far.mean()(0, 0) = 30000.0F;  // fewer fractional bits
  write_spz(scratch / "far.spz", far);
  EXPECT_NEAR(read_spz(scratch / "far.spz").mean()(0, 0), 30000.0F, 0.01F);
  write_splats(scratch / "none.spz", GaussianSet(SetKind::kCamera, 0, 0));
  EXPECT_EQ(read_spz(scratch / "none.spz").size(), 0);
}

/// Returns one particle, version 1 or 2, uncompressed, byte by byte.
std::string small_spz(char version) {
  std::string bytes("NGSP\x00\x00\x00\x00\x01\x00\x00\x00\x00\x08\x00\x00", 16);
  bytes[4] = version;
  if (version == 1) {
    bytes += std::string("\x00\x3c\x00\xc0\x00\x38", 6);  // halves 1, -2, 0.5
  } else {
    bytes += std::string("\x00\x01\x00\x00\xfe\xff\x80\x00\x00", 9);  // 256, -512, 128 of 1/256
  }
  bytes += "\x80";                                            // opacity 128 / 255
  bytes += std::string("\x80\xa6\x00", 3);                    // colours
  return bytes + std::string("\x80\x90\xa0\xff\x80\x80", 6);  // scales -2, -1, 0; a half turn about x
}

TEST(Spz, ScenesStandUpright) {
  const Scratch scratch;
  GaussianSet set = some_set(0, 1);
  set.mean().row(0) << 1.0F, 2.0F, 3.0F;  // ahead, left, up
  write_splats(scratch / "up.spz", set, {SplatAxes::kZUp});
  const GaussianSet right_down_ahead = read_splats(scratch / "up.spz");
  EXPECT_TRUE(Eigen::RowVector3f(right_down_ahead.mean().row(0))
                  .isApprox(Eigen::RowVector3f(-2.0F, -3.0F, 1.0F), 1e-4F));
}

TEST(Spz, ReadsOlderVersions) {
  const Scratch scratch;
  for (const char version : {'\1', '\2'}) {
    for (const bool packed : {false, true}) {
      const std::string bytes = small_spz(version);
      const GaussianSet set = read_spz(scratch.file("a.spz", packed ? gzip(bytes) : bytes));
      ASSERT_EQ(set.size(), 1);
      EXPECT_EQ(Eigen::RowVector3f(set.mean().row(0)), Eigen::RowVector3f(1.0F, 2.0F, -0.5F));
      EXPECT_EQ(Eigen::RowVector3f(set.log_scale().row(0)), Eigen::RowVector3f(-2.0F, -1.0F, 0.0F));
      EXPECT_NEAR(set.opacity_logit()(0), std::log(128.0F / 127.0F), 1e-4F);
      EXPECT_NEAR(set.sh(0)(0, 1), (166.0F / 255.0F - 0.5F) / 0.15F, 1e-4F);
      EXPECT_NEAR(set.rotation()(0, 1), 1.0F, 1e-4F);
      EXPECT_NEAR(set.rotation()(0, 0), 0.0F, 0.1F);
      for (const char flags : {'\0', '\1', '\2'}) {
        std::string flagged = bytes;
        flagged[14] = flags;
        SplatReport report;
        (void)read_splats(scratch.file("b.spz", packed ? gzip(flagged) : flagged), &report);
        EXPECT_EQ(report.is_antialiased, flags == '\1');
      }
    }
  }
}

TEST(Spz, TakesNoMoreMemoryThanItsSizeAllows) {
  const Scratch scratch;
  constexpr std::size_t kZeros = std::size_t{64} << 20U;
  expect_input_error([&] { (void)read_spz(gzip(small_spz(2) + std::string(kZeros, '\0')), "b.spz"); },
                     {"b.spz", "more than", "bytes"});
  std::string equal = small_spz(2).substr(0, 16);
  equal[10] = 0x20;  // two million: 38 MiB in 38 KiB
  equal.resize(16 + 19 * 0x200001, '\0');
  expect_input_error([&] { (void)read_spz(gzip(equal), "e.spz"); }, {"e.spz", "points", "2097153"});
  if (!has_zstd()) GTEST_SKIP() << "no Zstandard";
  for (const std::uint64_t points : {std::uint64_t{0xffffffff}, std::uint64_t{150'000'000}}) {
    std::string v4 = small_spz(2).substr(0, 16), streams;
    v4[4] = 4;
    v4[15] = 5;
    for (std::size_t i = 0; i < 4; ++i) v4[8 + i] = static_cast<char>(points >> 8U * i);
    append_little_endian(v4, 32, 4);
    v4.resize(32);
    for (const std::uint64_t bytes_each : {9, 1, 3, 3, 4}) {
      append_little_endian(v4, 12, 8);
      append_little_endian(v4, bytes_each * points, 8);
      streams += std::string(12, '\0');
    }
    expect_input_error([&] { (void)read_spz(v4 + streams, "c.spz"); }, {"c.spz", "points"});
  }
  expect_input_error([] { (void)unzstd("twelve bytes", 12, std::size_t{1} << 50U, "d.spz"); },
                     {"d.spz", "Zstandard data"});
}

TEST(Spz, RefusesWhatIsNotWhole) {
  const Scratch scratch;
  const auto refuse = [&](const std::string& bytes, const std::string& word) {
    expect_input_error([&] { (void)read_spz(scratch.file("b.spz", bytes)); }, {"b.spz", word});
  };
  const std::string good = small_spz(2);
  refuse("ply", "magic");
  refuse(good.substr(0, good.size() - 1), "points");
  refuse(gzip(good).substr(0, 30), "compressed data");
  for (const auto& [place, byte, word] : {std::tuple{4, '\x07', "version"},
                                          {12, '\x05', "SH degree"},
                                          {13, '\x40', "fractional bits"},
                                          {11, '\x7f', "points"}}) {
    std::string bad = good;
    bad[static_cast<std::size_t>(place)] = byte;
    refuse(bad, word);
  }
  std::string v4 = good;
  v4[4] = 4;
  v4.resize(64);
  refuse(v4, "table of contents");
  expect_input_error([&] { write_spz(scratch / "l.spz", GaussianSet(SetKind::kLidar, 0, 1)); }, {"l.spz"});
  expect_input_error([&] { write_splats(scratch / "l.splat", GaussianSet(SetKind::kCamera, 0, 0)); },
                     {".usdz"});
}

void append_float(std::string& to, float value) {
  char bytes[4];
  std::memcpy(bytes, &value, 4);
  to.append(bytes, 4);
}
void append_word(std::string& to, std::uint32_t value) {
  char bytes[4];
  std::memcpy(bytes, &value, 4);
  to.append(bytes, 4);
}

/// Returns two particles in one chunk: the first at all lower bounds, the second at all upper bounds.
std::string small_compressed(bool with_sh) {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement chunk 1\n";
  for (const char* low : {"min", "max"}) {
    for (const char* axis : {"x", "y", "z"}) text += std::string("property float ") + low + '_' + axis + '\n';
  }
  for (const char* low : {"min", "max"}) {
    for (const char* axis : {"x", "y", "z"}) {
      text += std::string("property float ") + low + "_scale_" + axis + '\n';
    }
  }
  for (const char* low : {"min", "max"}) {
    for (const char* axis : {"r", "g", "b"}) text += std::string("property float ") + low + '_' + axis + '\n';
  }
  text += "element vertex 2\n";
  for (const char* name : {"position", "rotation", "scale", "color"}) {
    text += std::string("property uint packed_") + name + '\n';
  }
  if (with_sh) {
    text += "element sh 2\n";
    for (int i = 0; i < 9; ++i) text += "property uchar f_rest_" + std::to_string(i) + '\n';
  }
  text += "end_header\n";
  for (const float bound : {-1.0F, -2.0F, -3.0F, 1.0F, 2.0F, 3.0F}) append_float(text, bound);
  for (const float bound : {-6.0F, -5.0F, -4.0F, -3.0F, -2.0F, -1.0F}) append_float(text, bound);
  for (const float bound : {0.0F, 0.1F, 0.2F, 1.0F, 0.9F, 0.8F}) append_float(text, bound);
  const std::uint32_t middle = 512U << 20U | 512U << 10U | 512U;  // nearly zero
  for (const std::uint32_t word : {0U, middle, 0U, 0U}) append_word(text, word);
  for (const std::uint32_t word : {~0U, 2U << 30U | middle, ~0U, ~0U}) append_word(text, word);
  if (with_sh) text += std::string("\x00\x01\x02\x03\x04\x05\x06\x07\x08", 9) + std::string(9, '\xff');
  return text;
}

TEST(CompressedPly, ReadsEveryField) {
  const Scratch scratch;
  const GaussianSet set = read_splats(scratch.file("a.compressed.ply", small_compressed(true)));
  ASSERT_EQ(set.size(), 2);
  ASSERT_EQ(set.sh_degree, 1);
  EXPECT_EQ(Eigen::RowVector3f(set.mean().row(0)), Eigen::RowVector3f(-1.0F, -2.0F, -3.0F));
  EXPECT_EQ(Eigen::RowVector3f(set.mean().row(1)), Eigen::RowVector3f(1.0F, 2.0F, 3.0F));
  EXPECT_EQ(Eigen::RowVector3f(set.log_scale().row(0)), Eigen::RowVector3f(-6.0F, -5.0F, -4.0F));
  EXPECT_NEAR(set.sh(0)(1, 1), (0.9F - 0.5F) / kSh0, 1e-4F);
  EXPECT_NEAR(set.opacity_logit()(0), std::log(0.5F / 254.5F), 1e-4F);
  EXPECT_NEAR(set.rotation()(0, 0), 1.0F, 1e-4F);  // the largest is w ...
  EXPECT_NEAR(set.rotation()(1, 2), 1.0F, 1e-4F);  // ... or y
  EXPECT_NEAR(set.sh(1)(0, 0), -4.0F, 1e-4F);      // channel-major: f_rest_0 is red
  EXPECT_NEAR(set.sh(1)(0, 1), (3.5F / 256.0F - 0.5F) * 8.0F, 1e-4F);
  EXPECT_NEAR(set.sh(3)(1, 2), 4.0F, 1e-4F);
}

TEST(CompressedPly, RefusesWhatDoesNotFit) {
  const Scratch scratch;
  const auto refuse =
      [&](std::string bytes, const std::string& from, const std::string& to, const char* word) {
        if (!from.empty()) bytes.replace(bytes.find(from), from.size(), to);
        expect_input_error([&] { (void)read_splats(scratch.file("b.ply", bytes)); }, {"b.ply", word});
      };
  const std::string good = small_compressed(false);
  refuse(good.substr(0, good.size() - 1), "", "", "data");
  refuse(good + "x", "", "", "data");
  refuse(good, "element chunk 1", "element chunk 2", "element vertex");
  refuse(good, "element vertex 2", "element vertex 9999999999", "element vertex");
  refuse(good, "min_g", "min_q", "element chunk");
  refuse(good, "packed_scale", "packed_other", "elements");
  refuse(good, "little", "big", "format");
  expect_input_error([&] { (void)read_gaussians_ply(scratch.file("c.ply", good), SetKind::kLidar); },
                     {"c.ply", "channels"});
}

TEST(SplatFiles, TheSameModelFromEitherFormat) {
  const char* const data = std::getenv("SIMULI_DATA");
  if (data == nullptr) GTEST_SKIP() << "not run: models of PlayCanvas as SPZ and PLY, SIMULI_DATA is not set";
  const std::filesystem::path folder = std::filesystem::path(data) / "splats";
  for (const char* name : {"minimal-raw.spz", "minimal-v2.spz", "minimal-v3.spz"}) {
    EXPECT_EQ(read_splats(folder / "splat_transform_fixtures" / name).size(), 4) << name;
  }
  const GaussianSet ply = read_splats(folder / "playcanvas" / "biker.compressed.ply");
  ASSERT_EQ(ply.size(), 152746);
  if (!has_zstd()) GTEST_SKIP() << "not run: SPZ version 4, this build has no libzstd";
  EXPECT_EQ(read_splats(folder / "splat_transform_fixtures" / "minimal-v4.spz").size(), 4);
  const GaussianSet spz = read_splats(folder / "playcanvas" / "biker.spz");
  ASSERT_EQ(spz.size(), ply.size());
  EXPECT_LT((spz.mean() - ply.mean()).cwiseAbs().maxCoeff(), 5e-4F);  // 1/4096 m and the chunks' steps
  EXPECT_LT((spz.sh(0) - ply.sh(0)).cwiseAbs().maxCoeff(), 0.05F);
}

}  // namespace
}  // namespace simuli
