#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <initializer_list>
#include <set>

#include "host/core/base/error.hpp"
#include "host/core/scene/placement.hpp"
#include "io/splat/glb.hpp"
#include "io/splat/glb_document.hpp"
#include "io/splat/ply.hpp"
#include "io/splat/splat_axes.hpp"
#include "io/splat/splat_file.hpp"
#include "io/splat/spz_bytes.hpp"

namespace simuli {
namespace {

using glb::Document;

template <class T>
float component(const char* from, bool is_normalized) {
  T value{};
  std::memcpy(&value, from, sizeof value);
  if constexpr (std::is_floating_point_v<T>) {
    return value;
  } else {
    const auto number = static_cast<float>(value);
    if (!is_normalized) return number;
    return std::max(number / static_cast<float>(std::numeric_limits<T>::max()), -1.0F);
  }
}

/// Allowed component types of an attribute.
enum Kinds : unsigned { kFloats = 1, kSigned = 2, kUnsigned = 4, kNotNormalized = 8 };

struct ComponentType {
  int number;
  std::size_t bytes;
  unsigned kinds;
  float (*read)(const char* from, bool is_normalized);
};
constexpr std::array kComponentTypes{
    ComponentType{glb::kByte, 1, kSigned, component<std::int8_t>},
    ComponentType{glb::kUnsignedByte, 1, kUnsigned, component<std::uint8_t>},
    ComponentType{glb::kShort, 2, kSigned, component<std::int16_t>},
    ComponentType{glb::kUnsignedShort, 2, kUnsigned, component<std::uint16_t>},
    ComponentType{glb::kFloat, 4, kFloats, component<float>},
};

class Reader {
 public:
  Reader(const std::string& bytes, const std::string& file, SplatReport* report)
      : document_(glb::read_document(bytes, file)), report_(report) {}

  GaussianSet read() {
    for (const std::size_t root : document_.roots) visit(root, Eigen::Affine3d::Identity());
    return joined();
  }

 private:
  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const {
    throw_input_error(document_.file, field, found, allowed);
  }

  void visit(std::size_t index, const Eigen::Affine3d& scene_from_parent) {
    // An explicit stack, because files may nest to any depth.
    std::vector<std::pair<std::size_t, Eigen::Affine3d>> open{{index, scene_from_parent}};
    while (!open.empty()) {
      const auto [at, scene_from_above] = open.back();
      open.pop_back();
      if (!visited_.insert(at).second) refuse("nodes", fmt::format("number {} twice", at), "a tree");
      const glb::Node& node = glb::at(document_.nodes, at, document_, "nodes");
      const Eigen::Affine3d scene_from_node = scene_from_above * node.parent_from_node;
      if (node.mesh) {
        for (const glb::Splats& splats : glb::at(document_.meshes, *node.mesh, document_, "meshes")) {
          sets_.push_back(placed(read(splats), scene_from_node));
        }
      }
      for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
        open.emplace_back(*child, scene_from_node);
      }
    }
  }

  /// Returns the set in this project's axes, transformed by the node.
  GaussianSet placed(GaussianSet set, const Eigen::Affine3d& scene_from_node) const {
    const Eigen::Matrix3d linear = scene_from_node.linear();
    const double scale = std::cbrt(linear.determinant());
    constexpr double kUneven = 1e-3;
    const Eigen::Matrix3d turn = linear / scale;
    if (!(scale > 0.0) || !scene_from_node.matrix().allFinite() ||
        !((turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm() < kUneven)) {
      refuse("nodes", "a matrix that shears, mirrors or scales unevenly", "turned, moved and scaled alone");
    }
    const Pose gltf_from_node{Eigen::Quaterniond(turn).normalized(), scene_from_node.translation()};
    const Pose down_from_gltf{(kGltfFromLevel * level_from(SplatAxes::kYDown)).conjugate(),
                              Eigen::Vector3d::Zero()};
    transform(set, down_from_gltf * gltf_from_node, scale);
    return set;
  }

  GaussianSet read(const glb::Splats& splats) {
    if (splats.spz_view) {
      const glb::View& view = glb::at(document_.views, *splats.spz_view, document_, "bufferViews");
      take(view.length);
      need_inside(view, "bufferViews", view.length);
      return set_of_spz(document_.binary.substr(view.offset, view.length), document_.file, report_);
    }
    int degree = 0;
    while (degree < 3 && splats.attributes.contains(glb::sh_name(sh_coefficients(degree)))) ++degree;
    const std::size_t count = accessor_of(splats, glb::kPosition).count;
    // Each particle needs bytes in the file; a claimed number alone allocates nothing.
    if (count > document_.binary.size())
      refuse("accessors", fmt::format("{} particles", count), "fewer bytes");
    GaussianSet set(SetKind::kCamera, degree, static_cast<Eigen::Index>(count));
    const auto fill = [&](const std::string& name, unsigned kinds, int first, int components) {
      read_attribute(splats, name, kinds, components, set, first);
    };
    fill(glb::kPosition, kFloats, kMeanRow, 3);
    fill(glb::kScale, kFloats | kUnsigned | kNotNormalized, kLogScaleRow, 3);
    fill(glb::kRotation, kFloats | kSigned, kRotationRow, 4);
    fill(glb::kOpacity, kFloats | kUnsigned, kOpacityRow, 1);
    for (int k = 0; k < sh_coefficients(degree); ++k) fill(glb::sh_name(k), kFloats, kShRow + 3 * k, 3);
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        float& scale = set.params(i, kLogScaleRow + c);
        if (scale < 0.0F) refuse(glb::kScale, fmt::format("{}", scale), "at least 0");
        scale = log_scale_of(scale);
      }
      const Eigen::RowVector4f xyzw = set.rotation().row(i);
      set.rotation().row(i) << xyzw[3], xyzw[0], xyzw[1], xyzw[2];
      float& opacity = set.params(i, kOpacityRow);
      if (opacity < 0.0F || opacity > 1.0F) refuse(glb::kOpacity, fmt::format("{}", opacity), "0 to 1");
      opacity = logit_of(opacity);
    }
    return set;
  }

  const glb::Accessor& accessor_of(const glb::Splats& splats, const std::string& name) const {
    const auto found = splats.attributes.find(name);
    if (found == splats.attributes.end()) refuse("attributes", "no " + name, "one");
    return glb::at(document_.accessors, found->second, document_, "accessors");
  }

  void read_attribute(const glb::Splats& splats,
                      const std::string& name,
                      unsigned kinds,
                      int components,
                      GaussianSet& set,
                      int first) {
    const glb::Accessor& accessor = accessor_of(splats, name);
    const auto type =
        std::find_if(kComponentTypes.begin(), kComponentTypes.end(), [&](const ComponentType& t) {
          return t.number == accessor.component_type;
        });
    const std::string shape = components == 1 ? "SCALAR" : fmt::format("VEC{}", components);
    const bool is_allowed =
        type != kComponentTypes.end() && (type->kinds & kinds) != 0 &&
        (type->kinds == kFloats || accessor.is_normalized || (kinds & kNotNormalized) != 0);
    if (!is_allowed || accessor.type != shape) {
      refuse(name,
             fmt::format("{} of type {}", accessor.type, accessor.component_type),
             shape + " of its types");
    }
    if (accessor.count != static_cast<std::size_t>(set.size())) {
      refuse(name, fmt::format("{} elements", accessor.count), fmt::format("{}", set.size()));
    }
    if (!accessor.view) refuse(name, "no bytes", "a bufferView");
    if (accessor.count == 0) return;
    const glb::View& view = glb::at(document_.views, *accessor.view, document_, "bufferViews");
    const std::size_t element = type->bytes * static_cast<std::size_t>(components);
    const std::size_t stride = view.stride > 0 ? view.stride : element;
    take(accessor.count * element);
    need_inside(view, name, accessor.offset + (accessor.count - 1) * stride + element);
    const char* from = document_.binary.data() + view.offset + accessor.offset;
    for (Eigen::Index i = 0; i < set.size(); ++i, from += stride) {
      for (int c = 0; c < components; ++c) {
        set.params(i, first + c) =
            type->read(from + type->bytes * static_cast<std::size_t>(c), accessor.is_normalized);
      }
    }
  }

  /// Checks that `bytes` bytes of a view exist.
  void need_inside(const glb::View& view, const std::string& field, std::size_t bytes) const {
    if (view.offset <= document_.binary.size() && view.length <= document_.binary.size() - view.offset &&
        bytes <= view.length) {
      return;
    }
    refuse(field,
           fmt::format("{} bytes of {} from {} on", bytes, view.length, view.offset),
           fmt::format("within the {} of this file", document_.binary.size()));
  }

  /// Bounds the total memory: many primitives of a small file can refer to the same bytes.
  void take(std::size_t bytes) {
    constexpr std::size_t kTimes = 4;
    taken_ += bytes;
    if (taken_ <= kTimes * document_.binary.size()) return;
    refuse("accessors", "the same bytes many times over", fmt::format("{} times at most", kTimes));
  }

  GaussianSet joined() {
    if (sets_.empty())
      refuse("meshes", std::string("none with ") + glb::kSplatting, "one in the default scene");
    int degree = 0;
    Eigen::Index count = 0;
    for (const GaussianSet& set : sets_) {
      degree = std::max(degree, set.sh_degree);
      count += set.size();
    }
    if (sets_.size() == 1) return std::move(sets_.front());
    GaussianSet all(SetKind::kCamera, degree, count);
    Eigen::Index row = 0;
    for (const GaussianSet& set : sets_) {
      all.params.block(row, 0, set.size(), set.params.cols()) = set.params;
      row += set.size();
    }
    return all;
  }

  Document document_;
  SplatReport* report_;
  std::set<std::size_t> visited_;
  std::vector<GaussianSet> sets_;
  std::size_t taken_ = 0;
};

}  // namespace

GaussianSet read_glb(const std::string& bytes, const std::string& file, SplatReport* report) {
  return Reader(bytes, file, report).read();
}

}  // namespace simuli
