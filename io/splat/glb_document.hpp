#pragma once
// A parsed binary glTF: the JSON parts required for splats, and the bytes.
#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace simuli::glb {

struct Accessor {
  std::optional<std::size_t> view = {};  // no value: all zeros, or values from elsewhere
  std::size_t offset = 0;                // within the view
  std::size_t count = 0;
  int component_type = 0;
  std::string type = {};  // "VEC3"
  bool is_normalized = false;
};

struct View {
  std::size_t offset = 0, length = 0;  // in the file's binary chunk
  std::size_t stride = 0;              // 0: contiguous elements
};

/// A primitive with splats.
struct Splats {
  std::map<std::string, std::size_t> attributes = {};  // indices of accessors
  std::optional<std::size_t> spz_view = {};
};

struct Node {
  Eigen::Affine3d parent_from_node = Eigen::Affine3d::Identity();
  std::optional<std::size_t> mesh = {};
  std::vector<std::size_t> children = {};
};

/// Accessor indices are not checked against their counts, nor views against the bytes.
struct Document {
  std::string file;    // for messages
  std::string binary;  // empty: no binary chunk
  std::vector<Accessor> accessors;
  std::vector<View> views;
  std::vector<std::vector<Splats>> meshes;  // primitives with splats of each mesh
  std::vector<Node> nodes;
  std::vector<std::size_t> roots;  // nodes of the default scene
};

/// Throws Error{kInput} naming file and field for data that is not a binary glTF 2.0, and for JSON that
/// read_glb() refuses.
[[nodiscard]] Document read_document(const std::string& bytes, const std::string& file);

/// Returns an element (accessor, view, ...) by index. Throws Error{kInput} for an index out of range.
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
