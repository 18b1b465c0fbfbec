#pragma once
// The header of a PLY file, for io/splat/ply_*.cpp.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

enum class PlyFormat { kAscii, kLittleEndian, kBigEndian };
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::size_t offset = 0;  // in bytes from the start of a binary vertex
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kLittleEndian;
  std::vector<std::string> comments;
  std::uint64_t vertices = 0;
  std::vector<PlyProperty> properties;  // of element vertex
  std::size_t vertex_bytes = 0;         // of one binary vertex
  bool other_elements = false;          // further elements follow the vertices
  std::uint64_t bytes_in_front = 0;     // of elements before the vertices in a binary file
  std::uint64_t values_in_front = 0;    // of elements before the vertices in an ascii file
  std::size_t body = 0;                 // offset of the data in the file

  /// Returns the index in `properties`, -1 for an unknown name.
  [[nodiscard]] int find(const std::string& name) const;
};

[[nodiscard]] std::size_t ply_size(PlyType type);
/// Whether the rest contains only a few blanks, line ends or zeros.
[[nodiscard]] bool is_blank(std::string_view rest);

/// Parses the header of `bytes`; `file` appears in messages. Throws Error{kInput} for data that is not PLY 1.0,
/// list properties of vertices, repeated properties, and more vertices than the file can contain. Elements
/// before the vertices must have scalar properties only.
[[nodiscard]] PlyHeader parse_ply_header(const std::string& bytes, const std::string& file);

}  // namespace simuli
