#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/core/base/error.hpp"
#include "host/core/base/srgb.hpp"
#include "host/core/base/version.hpp"
#include "io/base/bytes.hpp"
#include "io/splat/glb.hpp"
#include "io/splat/splat_axes.hpp"
#include "io/splat/splat_file.hpp"
#include "io/splat/spz_bytes.hpp"

namespace simuli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostBytes = 0xffffffffU;

void append_float(std::string& to, float value) {
  append_little_endian(to, std::bit_cast<std::uint32_t>(value), 4);
}

/// The mesh of a file: its attributes and their bytes.
class Mesh {
 public:
  explicit Mesh(const GaussianSet& set) : set_(set) {}

  /// Adds an attribute of floats `value(particle, component)`.
  template <class Value>
  void add_floats(const std::string& name, int components, Value&& value) {
    begin(name, glb::kFloat, components, false);
    for (Eigen::Index i = 0; i < set_.size(); ++i) {
      for (int c = 0; c < components; ++c) append_float(binary_, value(i, c));
    }
    end();
  }
  /// Adds linear colours and opacity for viewers without splat support.
  void add_colors() {
    begin(glb::kColor, glb::kUnsignedByte, 4, true);
    const auto byte = [](float x) { return static_cast<std::uint64_t>(std::lround(255.0F * x)); };
    for (Eigen::Index i = 0; i < set_.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        append_little_endian(binary_, byte(linear_of(0.5F + kSh0 * set_.sh(0)(i, c))), 1);
      }
      append_little_endian(binary_, byte(opacity_of(set_.opacity_logit()(i))), 1);
    }
    end();
  }
  /// Declares an attribute whose values are stored elsewhere.
  void declare(const std::string& name, int component_type, int components) {
    begin(name, component_type, components, component_type != glb::kFloat);
  }
  /// Appends bytes without an attribute; returns the index of their buffer view.
  std::size_t add_bytes(const std::string& bytes) {
    start_ = binary_.size();
    binary_ += bytes;
    return finish_view();
  }
  /// Sets the bounds of the last added attribute.
  void bound(const Eigen::RowVector3f& least, const Eigen::RowVector3f& most) {
    Json& accessor = accessors_.back();
    for (int c = 0; c < 3; ++c) {
      accessor["min"].push_back(least[c]);
      accessor["max"].push_back(most[c]);
    }
  }

  [[nodiscard]] Json& attributes() { return attributes_; }
  [[nodiscard]] Json& accessors() { return accessors_; }
  [[nodiscard]] Json& views() { return views_; }
  [[nodiscard]] std::string& binary() { return binary_; }

 private:
  void begin(const std::string& name, int component_type, int components, bool normalized) {
    static constexpr std::array<const char*, 5> kTypes{"", "SCALAR", "", "VEC3", "VEC4"};
    attributes_[name] = accessors_.size();
    accessors_.push_back({{"componentType", component_type},
                          {"count", set_.size()},
                          {"type", kTypes.at(static_cast<std::size_t>(components))}});
    if (normalized) accessors_.back()["normalized"] = true;
    start_ = binary_.size();
  }
  void end() { accessors_.back()["bufferView"] = finish_view(); }
  std::size_t finish_view() {
    views_.push_back({{"buffer", 0}, {"byteOffset", start_}, {"byteLength", binary_.size() - start_}});
    binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
    return views_.size() - 1;
  }

  const GaussianSet& set_;
  Json attributes_ = Json::object(), accessors_ = Json::array(), views_ = Json::array();
  std::string binary_;
  std::size_t start_ = 0;
};

void bound_positions(Mesh& mesh, const GaussianSet& set) {
  mesh.bound(set.mean().colwise().minCoeff(), set.mean().colwise().maxCoeff());
}

void add_attributes(Mesh& mesh, const GaussianSet& set) {
  mesh.add_floats(glb::kPosition, 3, [&](Eigen::Index i, int c) { return set.mean()(i, c); });
  bound_positions(mesh, set);
  mesh.add_colors();
  mesh.add_floats(
      glb::kRotation, 4, [&](Eigen::Index i, int c) { return unit_rotation(set, i)[(c + 1) % 4]; });
  mesh.add_floats(glb::kScale, 3, [&](Eigen::Index i, int c) { return std::exp(set.log_scale()(i, c)); });
  mesh.add_floats(glb::kOpacity, 1, [&](Eigen::Index i, int) { return opacity_of(set.opacity_logit()(i)); });
  for (int k = 0; k < sh_coefficients(set.sh_degree); ++k) {
    mesh.add_floats(glb::sh_name(k), 3, [&](Eigen::Index i, int c) { return set.sh(k)(i, c); });
  }
}

/// Adds the attributes of the draft's SPZ data: colour and opacity together, without degree 0.
std::size_t add_spz(Mesh& mesh, const GaussianSet& set, const std::string& file) {
  mesh.declare(glb::kPosition, glb::kFloat, 3);
  bound_positions(mesh, set);
  mesh.declare(glb::kColor, glb::kUnsignedByte, 4);
  mesh.declare(glb::kScale, glb::kFloat, 3);
  mesh.declare(glb::kRotation, glb::kFloat, 4);
  for (int k = 1; k < sh_coefficients(set.sh_degree); ++k) mesh.declare(glb::sh_name(k), glb::kFloat, 3);
  return mesh.add_bytes(spz_of(set, file));
}

}  // namespace

std::string glb_of(const GaussianSet& own, const SplatOutput& how, const std::string& file) {
  need_camera_set(own, file);
  if (own.size() == 0)
    throw_input_error(file, "particles", "none", "at least one: glTF has no empty accessors");
  const GaussianSet set = turned(own, kGltfFromLevel * level_from(how.axes));
  Mesh mesh(set);
  Json splatting{{"kernel", glb::kKernel},
                 {"colorSpace", glb::kColorSpace},
                 {"projection", "perspective"},
                 {"sortingMethod", "cameraDistance"}};
  Json used = Json::array({glb::kSplatting});
  if (how.compress) {
    const std::size_t view = add_spz(mesh, set, file);
    splatting["extensions"] = {{glb::kSpz, {{"bufferView", view}}}};
    used.push_back(glb::kSpz);
  } else {
    add_attributes(mesh, set);
  }
  Json root{{"asset", {{"version", "2.0"}, {"generator", std::string("simuli ") + version()}}},
            {"extensionsUsed", used}};
  if (how.compress) root["extensionsRequired"] = used;
  root["scene"] = 0;
  root["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
  root["nodes"] = Json::array({{{"mesh", 0}}});
  root["meshes"] = Json::array({{{"primitives",
                                  Json::array({{{"attributes", mesh.attributes()},
                                                {"mode", glb::kPoints},
                                                {"extensions", {{glb::kSplatting, splatting}}}}})}}});
  root["accessors"] = mesh.accessors();
  root["bufferViews"] = mesh.views();
  root["buffers"] = Json::array({{{"byteLength", mesh.binary().size()}}});
  std::string json = root.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t bytes =
      glb::kHeaderBytes + 2 * glb::kChunkHeaderBytes + json.size() + mesh.binary().size();
  if (bytes > kMostBytes) throw_input_error(file, "size", "more than 4 GiB", "less, or another format");
  std::string out(glb::kMagic);
  append_little_endian(out, glb::kVersion, 4);
  append_little_endian(out, bytes, 4);
  append_little_endian(out, json.size(), 4);
  append_little_endian(out, glb::kJsonChunk, 4);
  out += json;
  append_little_endian(out, mesh.binary().size(), 4);
  append_little_endian(out, glb::kBinaryChunk, 4);
  return out + mesh.binary();
}

}  // namespace simuli
