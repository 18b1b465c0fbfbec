#pragma once
// A binary glTF taken apart: what reading splats needs of its JSON, and its bytes.
#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace simuli::glb {

struct Accessor {
  std::optional<std::size_t> view = {};  // none: all zeros, or values from elsewhere
  std::size_t offset = 0;                // in the view
  std::size_t count = 0;
  int component_type = 0;
  std::string type = {};  // "VEC3"
  bool is_normalized = false;
};

struct View {
  std::size_t offset = 0, length = 0;  // of the file's binary chunk
  std::size_t stride = 0;              // 0: elements without gaps
};

/// A primitive with splats.
struct Splats {
  std::map<std::string, std::size_t> attributes = {};  // accessors
  std::optional<std::size_t> spz_view = {};
};

struct Node {
  Eigen::Affine3d parent_from_node = Eigen::Affine3d::Identity();
  std::optional<std::size_t> mesh = {};
  std::vector<std::size_t> children = {};
};

/// Indices are not checked against what they count, nor views against the bytes.
struct Document {
  std::string file;    // for messages
  std::string binary;  // empty: it has none
  std::vector<Accessor> accessors;
  std::vector<View> views;
  std::vector<std::vector<Splats>> meshes;  // the primitives of each that are splats
  std::vector<Node> nodes;
  std::vector<std::size_t> roots;  // of the default scene
};

/// Error{kInput} naming file and field for what is no binary glTF 2.0, and for what read_glb() refuses of its
/// JSON.
[[nodiscard]] Document read_document(const std::string& bytes, const std::string& file);

/// An accessor of the document, a view ...: Error{kInput} where there are fewer.
template <class T>
[[nodiscard]] const T& at(const std::vector<T>& all,
                          std::size_t index,
                          const Document& document,
                          const char* what);
[[noreturn]] void refuse_index(const Document& document,
                               const char* what,
                               std::size_t index,
                               std::size_t count);

template <class T>
const T& at(const std::vector<T>& all, std::size_t index, const Document& document, const char* what) {
  if (index >= all.size()) refuse_index(document, what, index, all.size());
  return all[index];
}

}  // namespace simuli::glb
