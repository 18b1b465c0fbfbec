#include "io/splat/glb_document.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/base/json_reader.hpp"
#include "io/splat/glb.hpp"

namespace simuli::glb {
namespace {

constexpr std::int64_t kMost = 0xffffffff;  // limit of bytes and elements: a file is smaller

std::size_t number_at(const std::string& bytes, std::size_t at) {
  std::size_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8U | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

/// The JSON and the binary chunk.
struct Chunks {
  std::string json, binary;
};

Chunks chunks_of(const std::string& bytes, const std::string& file) {
  if (bytes.size() < kHeaderBytes || !bytes.starts_with(kMagic)) {
    throw_input_error(file, "magic", "other bytes", "glTF: the binary form");
  }
  if (number_at(bytes, 4) != kVersion) {
    throw_input_error(file, "version", fmt::format("{}", number_at(bytes, 4)), "2");
  }
  if (number_at(bytes, 8) != bytes.size()) {
    throw_input_error(file,
                      "length",
                      fmt::format("{} bytes", number_at(bytes, 8)),
                      fmt::format("{}, as the file has", bytes.size()));
  }
  Chunks chunks;
  std::size_t at = kHeaderBytes;
  for (std::size_t i = 0; at < bytes.size(); ++i) {
    const std::size_t left = bytes.size() - at;
    const std::size_t length = left < kChunkHeaderBytes ? 0 : number_at(bytes, at);
    if (left < kChunkHeaderBytes || length > left - kChunkHeaderBytes) {
      throw_input_error(file, fmt::format("chunk {}", i), "cut short", "its stated length");
    }
    const std::size_t type = number_at(bytes, at + 4);
    if (i == 0 && type != kJsonChunk) throw_input_error(file, "chunk 0", "another one", "JSON");
    if (i == 0) chunks.json = bytes.substr(at + kChunkHeaderBytes, length);
    if (i == 1 && type == kBinaryChunk) chunks.binary = bytes.substr(at + kChunkHeaderBytes, length);
    at += kChunkHeaderBytes + length;
  }
  if (chunks.json.empty()) throw_input_error(file, "chunk 0", "none", "JSON");
  return chunks;
}

std::size_t size_of(JsonObject& object, const char* key, std::size_t otherwise) {
  return object.has(key) ? static_cast<std::size_t>(object.integer(key, 0, kMost)) : otherwise;
}

std::optional<std::size_t> index_of(JsonObject& object, const char* key) {
  if (!object.has(key)) return std::nullopt;
  return static_cast<std::size_t>(object.integer(key, 0, kMost));
}

std::vector<std::size_t> indices_of(JsonObject& object, const char* key) {
  std::vector<std::size_t> out;
  if (!object.has(key)) return out;
  for (const double value : object.numbers(key)) {
    if (!(value >= 0.0 && value <= static_cast<double>(kMost))) {
      throw_input_error(object.file(), object.field(key), fmt::format("{}", value), "indices");
    }
    out.push_back(static_cast<std::size_t>(value));
  }
  return out;
}

template <class Read>
auto all_of(JsonObject& root, const char* key, Read&& read) {
  std::vector<std::decay_t<std::invoke_result_t<Read&, JsonObject&>>> out;
  if (!root.has(key)) return out;
  return root.objects(key, [&](JsonObject& object) {
    object.ignore_other_keys();
    return read(object);
  });
}

Accessor accessor_of(JsonObject& object) {
  if (object.has("sparse")) throw_input_error(object.file(), object.field("sparse"), "one", "none");
  Accessor accessor{.view = index_of(object, "bufferView"),
                    .offset = size_of(object, "byteOffset", 0),
                    .count = size_of(object, "count", 0),
                    .component_type = static_cast<int>(object.integer("componentType", 0, kFloat)),
                    .type = object.text("type")};
  if (object.has("normalized")) accessor.is_normalized = object.boolean("normalized");
  return accessor;
}

View view_of(JsonObject& object) {
  if (object.integer("buffer", 0, kMost) != 0) {
    throw_input_error(object.file(), object.field("buffer"), "another one", "0, which is in this file");
  }
  return {
      size_of(object, "byteOffset", 0), size_of(object, "byteLength", 0), size_of(object, "byteStride", 0)};
}

void need_text(JsonObject& object, const char* key, const char* allowed) {
  const std::string found = object.text(key);
  if (found != allowed) throw_input_error(object.file(), object.field(key), '"' + found + '"', allowed);
}

std::optional<std::size_t> spz_view_of(JsonObject& splatting) {
  std::optional<std::size_t> view;
  if (!splatting.has("extensions")) return view;
  splatting.object("extensions", [&](JsonObject& extensions) {
    extensions.ignore_other_keys();
    if (!extensions.has(kSpz)) return;
    extensions.object(kSpz, [&](JsonObject& spz) {
      spz.ignore_other_keys();
      view = static_cast<std::size_t>(spz.integer("bufferView", 0, kMost));
    });
  });
  return view;
}

std::optional<Splats> splats_of(JsonObject& primitive) {
  std::optional<Splats> out;
  if (!primitive.has("extensions")) return out;
  primitive.object("extensions", [&](JsonObject& extensions) {
    extensions.ignore_other_keys();
    if (!extensions.has(kSplatting)) return;
    out.emplace();
    extensions.object(kSplatting, [&](JsonObject& splatting) {
      splatting.ignore_other_keys();
      out->spz_view = spz_view_of(splatting);
      // The draft's examples of compressed splats omit both.
      if (!out->spz_view || splatting.has("kernel")) need_text(splatting, "kernel", kKernel);
      if (!out->spz_view || splatting.has("colorSpace")) need_text(splatting, "colorSpace", kColorSpace);
    });
  });
  if (!out) return out;
  if (primitive.integer("mode", 0, kMost) != kPoints) {
    throw_input_error(primitive.file(), primitive.field("mode"), "another one", "0 (points)");
  }
  primitive.object("attributes", [&](JsonObject& attributes) {
    attributes.ignore_other_keys();
    for (const auto& [name, value] : primitive.get("attributes").items()) {
      out->attributes[name] = static_cast<std::size_t>(attributes.integer(name, 0, kMost));
    }
  });
  return out;
}

std::vector<Splats> mesh_of(JsonObject& mesh) {
  std::vector<Splats> out;
  for (std::optional<Splats>& splats : all_of(mesh, "primitives", splats_of)) {
    if (splats) out.push_back(std::move(*splats));
  }
  return out;
}

Node node_of(JsonObject& object) {
  Node node{.mesh = index_of(object, "mesh"), .children = indices_of(object, "children")};
  if (object.has("matrix")) {
    const Eigen::Matrix<double, 16, 1> columns = object.vector<16>("matrix");
    node.parent_from_node.matrix() = Eigen::Map<const Eigen::Matrix4d>(columns.data());
    return node;
  }
  if (object.has("translation")) node.parent_from_node.translate(object.vector<3>("translation"));
  if (object.has("rotation")) {
    const Eigen::Vector4d xyzw = object.vector<4>("rotation");
    if (!(xyzw.norm() > 0.0)) {
      throw_input_error(object.file(), object.field("rotation"), "a zero quaternion", "a rotation");
    }
    node.parent_from_node.rotate(Eigen::Quaterniond(xyzw.normalized()));
  }
  if (object.has("scale")) node.parent_from_node.scale(object.vector<3>("scale"));
  return node;
}

void need_known_extensions(JsonObject& root) {
  if (!root.has("extensionsRequired")) return;
  const Json& required = root.get("extensionsRequired");
  for (const Json& name : required.is_array() ? required : Json::array({required})) {
    if (name.is_string() && (name == kSplatting || name == kSpz)) continue;
    const std::string found = name.dump(-1, ' ', false, Json::error_handler_t::replace);
    throw_input_error(
        root.file(), root.field("extensionsRequired"), found, fmt::format("{} and {}", kSplatting, kSpz));
  }
}

}  // namespace

Document read_document(const std::string& bytes, const std::string& file) {
  Chunks chunks = chunks_of(bytes, file);
  Document out;
  out.file = file;
  out.binary = std::move(chunks.binary);
  read_json_text(chunks.json, file, [&](JsonObject& root) {
    root.ignore_other_keys();
    need_known_extensions(root);
    out.accessors = all_of(root, "accessors", accessor_of);
    out.views = all_of(root, "bufferViews", view_of);
    out.meshes = all_of(root, "meshes", mesh_of);
    out.nodes = all_of(root, "nodes", node_of);
    const auto scenes = all_of(root, "scenes", [](JsonObject& scene) { return indices_of(scene, "nodes"); });
    const std::size_t scene = size_of(root, "scene", 0);
    out.roots = at(scenes, scene, out, "scenes");
  });
  return out;
}

void refuse_index(const Document& document, const char* what, std::size_t index, std::size_t count) {
  throw_input_error(document.file, what, fmt::format("number {}", index), fmt::format("below {}", count));
}

}  // namespace simuli::glb
