#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>

#include "host/core/scene/placement.hpp"
#include "io/base/bytes.hpp"
#include "io/base/file.hpp"
#include "io/base/gzip.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_file.hpp"
#include "io/splat/spz_bytes.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/splat/some_set.hpp"

namespace simuli {
namespace glb_test {

using test::expect_input_error;
using test::Scratch;
using test::some_set;
using Json = nlohmann::ordered_json;

/// Returns a file of these two chunks according to section 4.4 of glTF 2.0.
std::string glb(std::string json, std::string binary) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string out("glTF\x02\x00\x00\x00", 8);
  append_little_endian(out, 12 + 8 + json.size() + 8 + binary.size(), 4);
  append_little_endian(out, json.size(), 4);
  out += "JSON" + json;
  append_little_endian(out, binary.size(), 4);
  return out + std::string("BIN\x00", 4) + binary;
}

struct Parts {
  Json json;
  std::string binary;
};

Parts parts_of(const std::string& bytes) {
  const auto length = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 8), std::string("glTF\x02\x00\x00\x00", 8));
  EXPECT_EQ(length(8), bytes.size());
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  const std::size_t json = length(12);
  EXPECT_EQ(json % 4, 0U);
  EXPECT_EQ(bytes.substr(20 + json + 4, 4), std::string("BIN\x00", 4));
  EXPECT_EQ(length(20 + json), bytes.size() - 28 - json);
  return {Json::parse(bytes.substr(20, json)), bytes.substr(28 + json)};
}

/// Returns all numbers of an attribute as floats.
std::vector<float> floats_of(const Parts& parts, const std::string& name) {
  const Json& primitive = parts.json.at("meshes").at(0).at("primitives").at(0);
  const Json& accessor =
      parts.json.at("accessors").at(primitive.at("attributes").at(name).get<std::size_t>());
  EXPECT_EQ(accessor.at("componentType"), 5126);
  const Json& view = parts.json.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
  std::vector<float> out(view.at("byteLength").get<std::size_t>() / 4);
  std::memcpy(out.data(), parts.binary.data() + view.at("byteOffset").get<std::size_t>(), 4 * out.size());
  return out;
}

/// Returns one particle ahead, to the left and above, in scene axes.
GaussianSet one_particle() {
  GaussianSet set(SetKind::kCamera, 1, 1);
  set.mean().row(0) << 10.0F, 20.0F, 30.0F;  // ahead, left, up
  set.log_scale().row(0) << std::log(1.0F), std::log(2.0F), 0.0F;
  set.rotation().row(0) << 2.0F, 0.0F, 0.0F, 0.0F;  // not normalised
  set.opacity_logit()(0) = std::log(0.25F / 0.75F);
  set.sh(0).row(0) << 0.0F, (1.0F - 0.5F) / kSh0, (0.0F - 0.5F) / kSh0;  // half, full and no light
  set.sh(1).row(0) << 0.1F, 0.0F, 0.0F;                                  // y: to the left
  set.sh(2).row(0) << 0.2F, 0.0F, 0.0F;                                  // z: up
  set.sh(3).row(0) << 0.3F, 0.0F, 0.0F;                                  // x: ahead
  return set;
}

TEST(Glb, HoldsWhatTheExtensionSays) {
  const std::string bytes = glb_of(one_particle(), {SplatAxes::kZUp}, "a.glb");
  const Parts parts = parts_of(bytes);
  EXPECT_EQ(parts.json.at("extensionsUsed"), Json::array({"KHR_gaussian_splatting"}));
  EXPECT_FALSE(parts.json.contains("extensionsRequired"));  // points for readers without support of splats
  EXPECT_EQ(parts.json.at("asset").at("version"), "2.0");
  const Json& primitive = parts.json.at("meshes").at(0).at("primitives").at(0);
  EXPECT_EQ(primitive.at("mode"), 0);
  EXPECT_EQ(primitive.at("extensions").at("KHR_gaussian_splatting"),
            Json::parse(R"({"kernel": "ellipse", "colorSpace": "srgb_rec709_display",
                            "projection": "perspective", "sortingMethod": "cameraDistance"})"));
  EXPECT_EQ(parts.json.at("buffers").at(0).at("byteLength"), parts.binary.size());
  // x left, y up, z forward.
  EXPECT_EQ(floats_of(parts, "POSITION"), (std::vector<float>{20.0F, 30.0F, 10.0F}));
  const Json& position = parts.json.at("accessors").at(primitive.at("attributes").at("POSITION").get<int>());
  EXPECT_EQ(position.at("min"), Json::array({20.0, 30.0, 10.0}));
  EXPECT_EQ(position.at("max"), Json::array({20.0, 30.0, 10.0}));
  EXPECT_EQ(position.at("type"), "VEC3");
  // x, y, z, w of norm 1: the rotation from scene axes to file axes. Scales along the particle's axes are
  // unchanged.
  const std::vector<float> q = floats_of(parts, "KHR_gaussian_splatting:ROTATION");
  ASSERT_EQ(q.size(), 4U);
  EXPECT_TRUE((Eigen::Quaternionf(q[3], q[0], q[1], q[2]) * Eigen::Vector3f(1.0F, 2.0F, 3.0F))
                  .isApprox(Eigen::Vector3f(2.0F, 3.0F, 1.0F), 1e-6F));
  const std::vector<float> scale = floats_of(parts, "KHR_gaussian_splatting:SCALE");
  EXPECT_NEAR(scale[1], 2.0F, 1e-6F);
  EXPECT_NEAR(floats_of(parts, "KHR_gaussian_splatting:OPACITY")[0], 0.25F, 1e-7F);
  EXPECT_NEAR(floats_of(parts, "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0")[1], 0.5F / kSh0, 1e-5F);
  // Orders -1, 0, 1 belong to y, z, x with the signs -, +, -: coefficients along left, up, ahead are along x,
  // y, z in the file.
  EXPECT_NEAR(floats_of(parts, "KHR_gaussian_splatting:SH_DEGREE_1_COEF_0")[0], -0.2F, 1e-6F);
  EXPECT_NEAR(floats_of(parts, "KHR_gaussian_splatting:SH_DEGREE_1_COEF_1")[0], -0.3F, 1e-6F);
  EXPECT_NEAR(floats_of(parts, "KHR_gaussian_splatting:SH_DEGREE_1_COEF_2")[0], 0.1F, 1e-6F);
  // COLOR_0 is linear: a picture value of one half is about a fifth.
  const Json& color = parts.json.at("accessors").at(primitive.at("attributes").at("COLOR_0").get<int>());
  EXPECT_EQ(color.at("componentType"), 5121);
  EXPECT_EQ(color.at("normalized"), true);
  const Json& view = parts.json.at("bufferViews").at(color.at("bufferView").get<std::size_t>());
  EXPECT_EQ(parts.binary.substr(view.at("byteOffset").get<std::size_t>(), 4),
            std::string("\x37\xff\x00\x40", 4));
}

TEST(Glb, ReadsWhatItWrote) {
  const Scratch scratch;
  for (const int degree : {0, 1, 2, 3}) {
    const GaussianSet set = some_set(degree, 50);
    write_splats(scratch / "a.glb", set);
    const GaussianSet back = read_splats(scratch / "a.glb");
    ASSERT_EQ(back.size(), set.size());
    ASSERT_EQ(back.sh_degree, degree);
    EXPECT_EQ(back.mean(), set.mean());
    EXPECT_LT((back.log_scale() - set.log_scale()).cwiseAbs().maxCoeff(), 1e-6F);
    EXPECT_LT((back.opacity_logit() - set.opacity_logit()).cwiseAbs().maxCoeff(), 1e-4F);
    const int sh = 3 * sh_coefficients(degree);
    EXPECT_LT((back.params.rightCols(sh) - set.params.rightCols(sh)).cwiseAbs().maxCoeff(), 1e-6F);
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      EXPECT_NEAR(std::abs(back.rotation().row(i).dot(set.rotation().row(i).normalized())), 1.0F, 1e-6F);
    }
  }
}

TEST(Glb, CarriesSpzInItsOwnAxes) {
  const GaussianSet set = one_particle();
  const Parts parts = parts_of(glb_of(set, {SplatAxes::kZUp, true}, "a.glb"));
  const Json used = Json::array({"KHR_gaussian_splatting", "KHR_gaussian_splatting_compression_spz_2"});
  EXPECT_EQ(parts.json.at("extensionsUsed"), used);
  EXPECT_EQ(parts.json.at("extensionsRequired"), used);
  const Json& primitive = parts.json.at("meshes").at(0).at("primitives").at(0);
  for (const auto& [name, index] : primitive.at("attributes").items()) {
    EXPECT_FALSE(parts.json.at("accessors").at(index.get<std::size_t>()).contains("bufferView")) << name;
    EXPECT_EQ(parts.json.at("accessors").at(index.get<std::size_t>()).at("count"), 1);
  }
  const Json& spz = primitive.at("extensions")
                        .at("KHR_gaussian_splatting")
                        .at("extensions")
                        .at("KHR_gaussian_splatting_compression_spz_2");
  const Json& view = parts.json.at("bufferViews").at(spz.at("bufferView").get<std::size_t>());
  const GaussianSet inside = set_of_spz(
      parts.binary.substr(view.at("byteOffset").get<std::size_t>(), view.at("byteLength").get<std::size_t>()),
      "spz");
  EXPECT_TRUE(
      Eigen::RowVector3f(inside.mean().row(0)).isApprox(Eigen::RowVector3f(20.0F, 30.0F, 10.0F), 1e-4F));
  const Scratch scratch;
  const GaussianSet many = some_set(2, 40);
  write_splats(scratch / "c.glb", many, {SplatAxes::kYDown, true});
  write_spz(scratch / "c.spz", many);
  const GaussianSet from_glb = read_splats(scratch / "c.glb"), from_spz = read_splats(scratch / "c.spz");
  EXPECT_LT((from_glb.mean() - from_spz.mean()).cwiseAbs().maxCoeff(), 1e-6F);
  EXPECT_LT((from_glb.params.rightCols(27) - from_spz.params.rightCols(27)).cwiseAbs().maxCoeff(), 1e-2F);
}

TEST(Glb, TellsWhatTheSpzInItTells) {
  const Scratch scratch;
  for (const char flags : {'\0', '\1'}) {
    Parts parts = parts_of(glb_of(some_set(0, 3), {SplatAxes::kYDown, true}, "a.glb"));
    std::string spz = gunzip(spz_of(some_set(0, 3), "a.spz"), "a.spz", 4096);
    spz[14] = flags;
    const std::size_t at = parts.binary.size(), end = at + spz.size();
    for (Json& view : parts.json.at("bufferViews")) {
      if (parts.binary.compare(view.value("byteOffset", std::size_t{0}), 2, "\x1f\x8b") == 0)
        view["byteOffset"] = at, view["byteLength"] = spz.size();
    }
    parts.json.at("buffers").at(0)["byteLength"] = end;
    SplatReport report;
    (void)read_splats(scratch.file("a.glb", glb(parts.json.dump(), parts.binary + spz)), &report);
    EXPECT_EQ(report.is_antialiased, flags == '\1');
  }
}

/// Returns one particle with integer attributes, interleaved, in a node with rotation, scale 2 and
/// translation.
std::string small_glb(const std::string& from = "", const std::string& to = "") {
  std::string json = R"({"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_gaussian_splatting"],
    "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"children": [1], "scale": [2, 2, 2]},
              {"mesh": 0, "translation": [0, 0, 5], "rotation": [0, 0.70710678118, 0, 0.70710678118]}],
    "meshes": [{"primitives": [{"mode": 0,
      "attributes": {"POSITION": 0, "KHR_gaussian_splatting:SCALE": 1, "KHR_gaussian_splatting:ROTATION": 2,
        "KHR_gaussian_splatting:OPACITY": 3, "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0": 4},
      "extensions": {"KHR_gaussian_splatting": {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3"},
      {"bufferView": 0, "byteOffset": 12, "componentType": 5121, "count": 1, "type": "VEC3"},
      {"bufferView": 0, "byteOffset": 16, "componentType": 5120, "normalized": true, "count": 1, "type": "VEC4"},
      {"bufferView": 0, "byteOffset": 20, "componentType": 5123, "normalized": true, "count": 1, "type": "SCALAR"},
      {"bufferView": 0, "byteOffset": 24, "componentType": 5126, "count": 1, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36, "byteStride": 36}], "buffers": [{"byteLength": 36}]})";
  if (!from.empty()) {
    const std::size_t at = json.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    json.replace(at, from.size(), to);
  }
  std::string binary;
  const auto append = [&](float value) {
    char bytes[4];
    std::memcpy(bytes, &value, 4);
    binary.append(bytes, 4);
  };
  for (const float x : {1.0F, 2.0F, 3.0F}) append(x);
  binary += std::string("\x01\x02\x00\x00", 4);  // scales 1, 2, 0 m
  binary += std::string("\x00\x00\x00\x7f", 4);  // no rotation: w = 127 / 127
  binary += std::string("\x33\x33\x00\x00", 4);  // 13107 / 65535: an opacity of a fifth
  for (const float c : {1.0F, -1.0F, 0.5F}) append(c);
  return glb(json, binary);
}

TEST(Glb, ReadsIntegersWhereNodesPutThem) {
  const Scratch scratch;
  const GaussianSet set = read_splats(scratch.file("n.glb", small_glb()));
  ASSERT_EQ(set.size(), 1);
  // A quarter rotation about y maps (1, 2, 3) to (3, 2, -1); plus five along z, twice as large: (6, 4, 8)
  // with x left, y up, z ahead. Right, down, ahead:
  EXPECT_TRUE(Eigen::RowVector3f(set.mean().row(0)).isApprox(Eigen::RowVector3f(-6.0F, -4.0F, 8.0F), 1e-5F));
  EXPECT_NEAR(set.log_scale()(0, 0), std::log(2.0F), 1e-6F);
  EXPECT_NEAR(set.log_scale()(0, 1), std::log(4.0F), 1e-6F);
  EXPECT_LT(set.log_scale()(0, 2), -19.0F);  // 0 m has no finite logarithm
  EXPECT_NEAR(set.opacity_logit()(0), std::log(0.25F), 1e-4F);
  const Eigen::RowVector4f wxyz = set.rotation().row(0);
  const Eigen::Quaternionf q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  EXPECT_TRUE((q * Eigen::Vector3f::UnitX()).isApprox(-Eigen::Vector3f::UnitZ(), 1e-5F));
  EXPECT_EQ(set.sh(0)(0, 1), -1.0F);
}

TEST(Glb, RefusesWhatDoesNotFit) {
  const Scratch scratch;
  const auto refuse = [&](const std::string& bytes, const std::string& word) {
    expect_input_error([&] { (void)read_splats(scratch.file("b.glb", bytes)); }, {"b.glb", word});
  };
  const auto refuse_json = [&](const std::string& from, const std::string& to, const std::string& word) {
    refuse(small_glb(from, to), word);
  };
  refuse("glTX", "magic");
  std::string bad = small_glb();
  bad[4] = 1;
  refuse(bad, "version");
  refuse(small_glb().substr(0, 100), "length");
  bad = small_glb();
  bad[12] = '\x7f';
  refuse(bad, "chunk");
  refuse_json("ellipse", "cube", "kernel");
  refuse_json("srgb_rec709_display", "lin_rec709_display", "colorSpace");
  refuse_json(R"("mode": 0)", R"("mode": 4)", "mode");
  refuse_json(R"("scene": 0)", R"("scene": 7)", "scenes");
  refuse_json(R"("children": [1])", R"("children": [0])", "twice");
  refuse_json(R"("children": [1])", R"("children": [-1])", "children");
  refuse_json(R"("mesh": 0)", R"("mesh": 3)", "meshes");
  refuse_json(R"("scale": [2, 2, 2])", R"("scale": [2, 2, 1])", "nodes");
  refuse_json(R"("scale": [2, 2, 2])", R"("scale": [-2, -2, -2])", "nodes");
  refuse_json(R"(splatting:OPACITY": 3)", R"(splatting:OPACITY": 9)", "accessors");
  refuse_json(R"(splatting:OPACITY": 3)", R"(splatting:OPACITY": 0)", "OPACITY");
  refuse_json(R"(splatting:OPACITY")", R"(splatting:TRANSPARENCY")", "OPACITY");
  refuse_json(R"("count": 1)", R"("count": 4000000000)", "accessors");
  refuse_json(R"("count": 1)", R"("count": 2)", "POSITION");
  refuse_json(R"("byteOffset": 24)", R"("byteOffset": 25)", "SH_DEGREE_0");
  refuse_json(R"("byteLength": 36, "byteStride")", R"("byteLength": 37, "byteStride")", "36 of this file");
  refuse_json(R"("buffer": 0)", R"("buffer": 1)", "buffer");
  refuse_json(R"("componentType": 5120)", R"("componentType": 5121)", "ROTATION");
  refuse_json(R"("extensionsUsed")",
              R"("extensionsRequired": ["EXT_meshopt_compression"], "extensionsUsed")",
              "meshopt");
  refuse_json(R"("count": 1)", R"("sparse": {}, "count": 1)", "sparse");
  refuse_json(R"({"mesh": 0,)", R"({)", "meshes");
  expect_input_error([&] { write_splats(scratch / "l.glb", GaussianSet(SetKind::kLidar, 0, 0)); },
                     {"l.glb", "kind"});
  expect_input_error([&] { write_splats(scratch / "n.glb", GaussianSet(SetKind::kCamera, 0, 0)); }, {"none"});
  expect_input_error(
      [&] {
        write_splats(scratch / "n.ply", some_set(0, 1), {SplatAxes::kZUp, true});
      },
      {"n.ply", "compression"});
  EXPECT_FALSE(std::filesystem::exists(scratch / "l.glb"));
}

/// A small file that references the same bytes a thousand times.
TEST(Glb, TakesNoMemoryForRepetition) {
  const Scratch scratch;
  std::string nodes = R"("nodes": [)", roots;
  for (int i = 0; i < 1000; ++i) {
    nodes += std::string(i > 0 ? ", " : "") + R"({"mesh": 0})";
    roots += (i > 0 ? ", " : "") + std::to_string(i);
  }
  std::string bytes = small_glb(R"({"nodes": [0]})", R"({"nodes": [)" + roots + "]}");
  Parts parts = parts_of(bytes);
  parts.json["nodes"] = Json::parse("{" + nodes + "]}").at("nodes");
  const std::string file = scratch.file("r.glb", glb(parts.json.dump(), parts.binary));
  expect_input_error([&] { (void)read_splats(file); }, {"r.glb", "many times"});
}

}  // namespace glb_test
}  // namespace simuli
