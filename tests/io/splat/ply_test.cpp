#include "io/splat/ply.hpp"

#include <algorithm>
#include <bit>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <random>

#include "io/base/file.hpp"
#include "io/scene/scene_folder.hpp"
#include "io/splat/splat_file.hpp"
#include "tests/io/ascii_ply.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace ply_test {

using test::ascii_ply;
using test::expect_input_error;
using test::Scratch;

/// Returns any finite float, including subnormals.
float any_float(std::mt19937_64& random) {
  for (;;) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (std::isfinite(value)) return value;
  }
}

GaussianSet any_set(SetKind kind, int degree, Eigen::Index count) {
  std::mt19937_64 random(static_cast<std::uint64_t>(degree) + 11);
  GaussianSet set(kind, degree, count);
  for (Eigen::Index v = 0; v < count; ++v) {
    for (Eigen::Index c = 0; c < set.params.cols(); ++c) set.params(v, c) = any_float(random);
    set.params(v, kRotationRow) = 1.0F;
  }
  return set;
}

/// Whether all bits are equal, including -0 and subnormals.
bool same_bits(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         (a.size() == 0 ||
          std::memcmp(a.data(), b.data(), sizeof(float) * static_cast<std::size_t>(a.size())) == 0);
}

/// An independent reader of little-endian files with only float properties.
std::map<std::string, std::vector<float>> read_plain(const std::string& bytes) {
  const std::size_t end = bytes.find("end_header\n") + 11;
  std::vector<std::string> names;
  std::size_t count = 0;
  for (std::size_t at = 0; at < end;) {
    const std::size_t stop = bytes.find('\n', at);
    const std::string line = bytes.substr(at, stop - at);
    if (line.starts_with("property float ")) names.push_back(line.substr(15));
    if (line.starts_with("element vertex ")) count = std::stoul(line.substr(15));
    at = stop + 1;
  }
  EXPECT_EQ(bytes.size(), end + 4 * count * names.size());
  std::map<std::string, std::vector<float>> columns;
  for (std::size_t v = 0; v < count; ++v) {
    for (std::size_t p = 0; p < names.size(); ++p) {
      float value = 0.0F;
      std::memcpy(&value, bytes.data() + end + 4 * (v * names.size() + p), 4);
      columns[names[p]].push_back(value);
    }
  }
  return columns;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Ply, RoundTripKeepsEveryBit) {
  const Scratch scratch;
  for (const SetKind kind : {SetKind::kCamera, SetKind::kLidar}) {
    for (int degree = 0; degree <= 3; ++degree) {
      const GaussianSet set = any_set(kind, degree, 257);
      write_gaussians_ply(scratch / "set.ply", set);
      const GaussianSet back = read_gaussians_ply(scratch / "set.ply", kind);
      EXPECT_EQ(back.kind, kind);
      EXPECT_EQ(back.sh_degree, degree);
      EXPECT_TRUE(same_bits(set.params, back.params)) << "degree " << degree;
    }
  }
}

TEST(Ply, EmptySetIsASet) {
  const Scratch scratch;
  write_gaussians_ply(scratch / "set.ply", GaussianSet(SetKind::kCamera, 2, 0));
  const GaussianSet back = read_gaussians_ply(scratch / "set.ply", SetKind::kCamera);
  EXPECT_EQ(back.size(), 0);
  EXPECT_EQ(back.sh_degree, 2);
}

TEST(Ply, FileHasTheStandardLayout) {
  const Scratch scratch;
  const GaussianSet set = any_set(SetKind::kLidar, 1, 3);
  write_gaussians_ply(scratch / "set.ply", set);
  const std::string bytes = read_file(scratch / "set.ply");
  EXPECT_NE(bytes.find("comment simuli channels intensity hit_logit drop_logit\n"), std::string::npos);
  EXPECT_NE(bytes.find("property float z\nproperty float nx\n"), std::string::npos);
  auto columns = read_plain(bytes);
  for (Eigen::Index v = 0; v < 3; ++v) {
    const auto i = static_cast<std::size_t>(v);
    EXPECT_EQ(columns["y"][i], set.mean()(v, 1));
    EXPECT_EQ(columns["ny"][i], 0.0F);
    EXPECT_EQ(columns["opacity"][i], set.opacity_logit()(v));
    EXPECT_EQ(columns["scale_2"][i], set.log_scale()(v, 2));
    EXPECT_EQ(columns["rot_0"][i], set.rotation()(v, 0));
    EXPECT_EQ(columns["f_dc_1"][i], set.sh(0)(v, 1));
    // Channel-major: 3 higher coefficients of channel 0, then those of channel 1.
    EXPECT_EQ(columns["f_rest_1"][i], set.sh(2)(v, 0));
    EXPECT_EQ(columns["f_rest_3"][i], set.sh(1)(v, 1));
    EXPECT_EQ(columns["f_rest_8"][i], set.sh(3)(v, 2));
  }
}

TEST(Ply, OtherWritersFilesAreUnderstood) {
  const Scratch scratch;
  // CRLF, comments before the format, doubles and integers, another order, unknown properties, faces.
  const std::string text =
      "ply\r\ncomment made elsewhere\r\nformat ascii 1.0\r\nobj_info x\r\nelement vertex 2\r\n"
      "property double rot_3\r\nproperty char rot_2\r\nproperty uint8 rot_1\r\nproperty short rot_0\r\n"
      "property ushort scale_2\r\nproperty int scale_1\r\nproperty uint scale_0\r\nproperty float64 "
      "opacity\r\n"
      "property float32 f_dc_2\r\nproperty float f_dc_1\r\nproperty float f_dc_0\r\nproperty uchar red\r\n"
      "property float z\r\nproperty float y\r\nproperty float x\r\n"
      "element face 1\r\nproperty list uchar int vertex_indices\r\nend_header\r\n"
      "1e-1 -2 3 4 5 6 7 -8.5 9 10 +11 255 13 14 15\r\n"
      "0 0 0 1 0 0 0 0 0 0 0 0 0 0 -1.5\r\n"
      "3 0 1 0\r\n";
  const GaussianSet set = read_gaussians_ply(scratch.file("other.ply", text), SetKind::kCamera);
  ASSERT_EQ(set.size(), 2);
  EXPECT_EQ(set.rotation().row(0), Eigen::RowVector4f(4.0F, 3.0F, -2.0F, 0.1F));
  EXPECT_EQ(set.log_scale().row(0), Eigen::RowVector3f(7.0F, 6.0F, 5.0F));
  EXPECT_EQ(set.opacity_logit()(0), -8.5F);
  EXPECT_EQ(set.sh(0).row(0), Eigen::RowVector3f(11.0F, 10.0F, 9.0F));
  EXPECT_EQ(set.mean().row(0), Eigen::RowVector3f(15.0F, 14.0F, 13.0F));
  EXPECT_EQ(set.mean()(1, 0), -1.5F);
}

TEST(Ply, TheFilterOfMipSplattingIsApplied) {
  const Scratch scratch;
  const std::string text = ascii_ply("property float filter_3D\n", "1 2 3 4 5 6 0.5 -2 -1 0 1 0 0 0 0.3\n");
  const GaussianSet set = read_gaussians_ply(scratch.file("mip.ply", text), SetKind::kCamera);
  double share = 1.0 / (1.0 + std::exp(-0.5));
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double own = std::exp(static_cast<double>(i - 2)), both = std::hypot(own, 0.3);
    EXPECT_NEAR(set.log_scale()(0, i), std::log(both), 1e-6);
    share *= own / both;
  }
  EXPECT_NEAR(set.opacity_logit()(0), std::log(share / (1.0 - share)), 1e-6);
}

TEST(Ply, BothByteOrdersAndAllTypes) {
  const Scratch scratch;
  const auto file = [&](bool big) {
    std::string text =
        std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\nelement vertex 1\n" +
        "property char x\nproperty ushort y\nproperty int z\nproperty uint f_dc_0\nproperty short f_dc_1\n" +
        "property uchar f_dc_2\nproperty double opacity\n";
    for (const char* name : {"scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"}) {
      text += std::string("property float ") + name + "\n";
    }
    text += "end_header\n";
    const auto put = [&](std::uint64_t bits, int bytes) {
      for (int i = 0; i < bytes; ++i) {
        text.push_back(static_cast<char>((bits >> (8 * (big ? bytes - 1 - i : i))) & 0xffU));
      }
    };
    put(0xfb, 1);                                 // -5
    put(0xfffe, 2);                               // 65534
    put(static_cast<std::uint32_t>(-70000), 4);   // -70000
    put(3000000000U, 4);                          // 3e9
    put(static_cast<std::uint16_t>(-300), 2);     // -300
    put(200, 1);                                  // 200
    put(std::bit_cast<std::uint64_t>(-2.25), 8);  // -2.25
    for (int i = 0; i < 7; ++i) put(std::bit_cast<std::uint32_t>(0.5F + static_cast<float>(i)), 4);
    return text;
  };
  for (const bool big : {false, true}) {
    const GaussianSet set = read_gaussians_ply(scratch.file("types.ply", file(big)), SetKind::kCamera);
    ASSERT_EQ(set.size(), 1);
    EXPECT_EQ(set.mean().row(0), Eigen::RowVector3f(-5.0F, 65534.0F, -70000.0F));
    EXPECT_EQ(set.sh(0).row(0), Eigen::RowVector3f(3e9F, -300.0F, 200.0F));
    EXPECT_EQ(set.opacity_logit()(0), -2.25F);
    EXPECT_EQ(set.rotation().row(0), Eigen::RowVector4f(3.5F, 4.5F, 5.5F, 6.5F));
  }
}

TEST(Ply, AsciiIsReadTheSameInAnyLocale) {
  const Scratch scratch;
  const std::string old_locale = std::setlocale(LC_ALL, nullptr);
  // Any installed locale with a decimal comma; the check also holds without one.
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8"}) {
    if (std::setlocale(LC_ALL, name) != nullptr) break;
  }
  const auto file = scratch.file("a.ply", ascii_ply("", "1.5 2 3 4 5 6 7 8 9 10 1 0 0 0"));
  const GaussianSet set = read_gaussians_ply(file, SetKind::kCamera);
  std::setlocale(LC_ALL, old_locale.c_str());
  EXPECT_EQ(set.mean()(0, 0), 1.5F);
}

TEST(Ply, BadHeadersAreRefused) {
  const Scratch scratch;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    const auto file = scratch.file("bad.ply", text);
    expect_input_error([&] { (void)read_gaussians_ply(file, SetKind::kCamera); }, words);
  };
  const std::string good = ascii_ply();
  ASSERT_EQ(read_gaussians_ply(scratch.file("good.ply", good), SetKind::kCamera).size(), 1);
  refused("", {"bad.ply", "no further line"});
  refused(replaced(good, "ply\n", "plx\n"), {"bad.ply", "line 1", "magic", "plx"});
  refused(replaced(good, "ascii 1.0", "ascii 2.0"), {"line 2", "ascii 2.0"});
  refused(replaced(good, "float y", "floot y"), {"line 5", "property type", "floot"});
  refused(replaced(good, "float y", "list uchar int y"), {"line 5", "list uchar int y", "scalar"});
  refused(replaced(good, "float y", "float x"), {"line 5", "second", "x"});
  refused(replaced(good, "float y", "float why"), {"property y", "none"});
  refused(replaced(good, "float scale_2", "float other"), {"2 (flat discs"});
  refused(replaced(good, "element vertex 1", "element vertex -1"), {"line 3", "-1"});
  refused(replaced(good, "element vertex 1", "element face 1"), {"line 18", "element vertex", "none"});
  refused(replaced(good, "vertex 1", "vertex 99999999999999999999"), {"line 3", "2^64"});
  refused(replaced(good, "element vertex 1\n", ""), {"line 3", "an element before it"});
  refused(replaced(good, "end_header", "end_hooder"), {"keyword", "end_hooder"});
  refused(
      replaced(good, "end_header\n", "comment simuli channels intensity hit_logit drop_logit\nend_header\n"),
      {"channels", "red green blue"});
  refused(ascii_ply("property float f_rest_0\n", "1 2 3 4 5 6 7 8 9 10 1 0 0 0 0\n"),
          {"f_rest", "found 1", "0, 9, 24 or 45"});
  refused(std::string(2 << 20, '\n'), {"bad.ply", "magic"});
}

TEST(Ply, CountsThatTheFileCannotHoldAreRefused) {
  const Scratch scratch;
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    const auto file = scratch.file("bad.ply", text);
    expect_input_error([&] { (void)read_gaussians_ply(file, SetKind::kCamera); }, words);
  };
  refused(replaced(ascii_ply(), "vertex 1", "vertex 4000000000"), {"4000000000 vertices", "at most"});
  refused(replaced(ascii_ply(), "vertex 1", "vertex 18446744073709551615"),
          {"18446744073709551615", "at most"});
  refused(replaced(ascii_ply(), "vertex 1", "vertex 2"), {"2 vertices", "at most 1"});
  write_gaussians_ply(scratch / "set.ply", any_set(SetKind::kCamera, 3, 10));
  const std::string binary = read_file(scratch / "set.ply");
  refused(replaced(binary, "vertex 10", "vertex 4000000000"), {"4000000000 vertices", "at most 10"});
  refused(binary.substr(0, binary.size() - 1), {"10 vertices", "at most 9"});
  refused(binary + "x", {"10 vertices and 1 bytes", "nothing behind"});
  refused(ascii_ply() + "7\n", {"more values", "nothing behind"});
}

TEST(Ply, BadValuesAreRefusedByVertexAndProperty) {
  const Scratch scratch;
  const auto refused = [&](const std::string& values, const std::vector<std::string>& words) {
    const auto file = scratch.file("bad.ply", ascii_ply("", values));
    expect_input_error([&] { (void)read_gaussians_ply(file, SetKind::kCamera); }, words);
  };
  refused("1 nan 3 4 5 6 7 8 9 10 1 0 0 0\n", {"vertex 0: y", "NaN or Inf"});
  refused("1 2 -inf 4 5 6 7 8 9 10 1 0 0 0\n", {"vertex 0: z", "NaN or Inf"});
  refused("1 2 3 4 5 6 1e39 8 9 10 1 0 0 0\n", {"vertex 0: opacity", "NaN or Inf"});
  refused("1 2 3 4 5 6 1e999 8 9 10 1 0 0 0\n", {"vertex 0: opacity", "NaN or Inf"});
  refused("1 2 3 4 5 6 7 8 9 1,5 1 0 0 0\n", {"vertex 0: scale_2", "no number"});
  refused("1 2 3 4 5 6 7 8 9 10 0 0 -0 0\n", {"vertex 0", "zero quaternion"});
  refused("1.25 2.25 3.25 4.25 5.25 6.25 7.25\n", {"vertex 0: scale_0", "end of the file"});
  // The same in a binary file, at another vertex.
  write_gaussians_ply(scratch / "set.ply", any_set(SetKind::kCamera, 0, 5));
  std::string bytes = read_file(scratch / "set.ply");
  const std::size_t vertex = 4 * 17;  // 14 properties and the normals
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + bytes.size() - 2 * vertex, &nan, 4);
  const auto file = scratch.file("nan.ply", bytes);
  expect_input_error([&] { (void)read_gaussians_ply(file, SetKind::kCamera); }, {"nan.ply", "vertex 3: x"});
}

TEST(Ply, OneBadParticleOfAnothersFileIsLeftOut) {
  const Scratch scratch;
  const std::string rows =
      "1 2 3 4 5 6 inf 8 9 10 1 0 0 0\n"
      "2 nan 3 4 5 6 7 8 9 10 1 0 0 0\n"
      "3 2 3 4 5 6 -inf 8 9 10 1 0 0 0\n"
      "4 2 3 4 5 6 7 8 9 10 0 0 -0 0\n"
      "5 2 3 4 5 6 7 8 1e39 10 1 0 0 0\n"
      "6 2 3 4 5 6 1e-999 8 9 10 1 0 0 0\n";
  const std::string text = replaced(ascii_ply("", rows), "vertex 1", "vertex 6");
  SplatReport report;
  const GaussianSet set = read_splats(scratch.file("a.ply", text), &report);
  ASSERT_EQ(set.size(), 3);
  EXPECT_EQ(report.left_out, 3);
  // The same if such a file is read as a scene.
  const SceneFile scene = read_scene(scratch / "a.ply");
  EXPECT_EQ(scene.scene.camera.size(), 3);
  EXPECT_EQ(scene.splats.left_out, 3);
  EXPECT_EQ(set.mean().col(0), Eigen::Vector3f(1.0F, 3.0F, 6.0F));
  // sigmoid(Inf) is 1, sigmoid(-Inf) 0: read like the bytes 255 and 0.
  EXPECT_FLOAT_EQ(set.opacity_logit()(0), std::log(509.0F));
  EXPECT_FLOAT_EQ(set.opacity_logit()(1), -std::log(509.0F));
  EXPECT_EQ(set.opacity_logit()(2), 0.0F);
  const auto none = scratch.file("b.ply", ascii_ply("", "1 nan 3 4 5 6 7 8 9 10 1 0 0 0\n"));
  expect_input_error([&] { (void)read_splats(none, &report); }, {"b.ply", "1, none of them sound"});
}

TEST(Ply, ElementsInFrontAndBlanksBehindAreSkipped) {
  const Scratch scratch;
  write_gaussians_ply(scratch / "set.ply", any_set(SetKind::kCamera, 1, 10));
  const std::string binary = read_file(scratch / "set.ply");
  const std::string front = replaced(
      binary, "element vertex", "element camera 2\nproperty float a\nproperty uchar b\nelement vertex");
  const std::size_t body = front.find("end_header\n") + 11;
  const Eigen::MatrixXf params = read_splats(scratch / "set.ply").params;
  const std::vector<std::string> others{binary + "\n",
                                        binary + "\r\n",
                                        binary + std::string(3, '\0'),
                                        std::string(front).insert(body, 10, 'x')};
  for (const std::string& other : others)
    EXPECT_TRUE(same_bits(params, read_splats(scratch.file("b.ply", other)).params));
  std::string ascii =
      replaced(ascii_ply(), "element vertex", "element camera 2\nproperty int a\nelement vertex");
  ascii = replaced(ascii, "end_header\n", "end_header\n7\n8\n");
  EXPECT_EQ(read_splats(scratch.file("c.ply", ascii)).params,
            read_splats(scratch.file("d.ply", ascii_ply())).params);
  for (const std::string& bad : {replaced(front, "camera 2", "camera 18446744073709551615"),
                                 replaced(front, "camera 2", "camera 400"),
                                 replaced(front, "uchar b", "list uchar int b"),
                                 binary + "\n\n\n\n\n"}) {
    expect_input_error([&] { (void)read_splats(scratch.file("e.ply", bad)); }, {"e.ply"});
  }
}

TEST(Ply, NothingUnreadableIsWritten) {
  const Scratch scratch;
  const auto refused = [&](const GaussianSet& set, const std::vector<std::string>& words) {
    expect_input_error([&] { write_gaussians_ply(scratch / "set.ply", set); }, words);
    EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
  };
  GaussianSet set = any_set(SetKind::kCamera, 1, 4);
  set.params(2, kLogScaleRow) = std::numeric_limits<float>::infinity();
  refused(set, {"set.ply", "vertex 2: scale_0"});
  set = any_set(SetKind::kCamera, 1, 4);
  set.rotation().row(1).setZero();
  refused(set, {"vertex 1", "zero quaternion"});
  set.sh_degree = 2;
  refused(set, {"columns", "SH degree 2"});
}

TEST(Ply, PointCloudHoldsItsColumns) {
  const Scratch scratch;
  PointCloud cloud{{"x", "y", "z", "intensity", "ring"}, {}};
  cloud.values.resize(3, 5);
  for (Eigen::Index i = 0; i < cloud.values.size(); ++i)
    cloud.values.data()[i] = static_cast<double>(0.1F * static_cast<float>(i));
  write_point_cloud_ply(scratch / "cloud.ply", cloud);
  auto columns = read_plain(read_file(scratch / "cloud.ply"));
  ASSERT_EQ(columns.size(), 5U);
  for (Eigen::Index v = 0; v < 3; ++v) {
    for (Eigen::Index c = 0; c < 5; ++c) {
      EXPECT_EQ(columns[cloud.columns[static_cast<std::size_t>(c)]][static_cast<std::size_t>(v)],
                static_cast<float>(cloud.values(v, c)));
    }
  }
  const auto refused = [&](const PointCloud& bad, const std::vector<std::string>& words) {
    expect_input_error([&] { write_point_cloud_ply(scratch / "bad.ply", bad); }, words);
    EXPECT_FALSE(std::filesystem::exists(scratch / "bad.ply"));
  };
  PointCloud bad = cloud;
  bad.values(1, 3) = std::nan("");
  refused(bad, {"vertex 1: intensity", "NaN"});
  bad = cloud;
  bad.columns[4] = "two words";
  refused(bad, {"two words"});
  bad.columns[4] = "x";
  refused(bad, {"x"});
  bad.columns.pop_back();
  refused(bad, {"4 names for 5 columns"});
}

}  // namespace ply_test
}  // namespace simuli
