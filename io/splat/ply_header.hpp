#pragma once
// The header of a PLY file. Included by io/ply_*.cpp alone.
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
  std::size_t offset = 0;  // bytes from the start of a binary vertex
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kLittleEndian;
  std::vector<std::string> comments;
  std::uint64_t vertices = 0;
  std::vector<PlyProperty> properties;  // of element vertex
  std::size_t vertex_bytes = 0;         // of one binary vertex
  bool other_elements = false;          // elements follow the vertices
  std::uint64_t bytes_in_front = 0;     // of elements in front of the vertices, in a binary file
  std::uint64_t values_in_front = 0;    // the same in an ascii file
  std::size_t body = 0;                 // where the data start in the file

  /// Index into `properties`, -1 when there is none of that name.
  [[nodiscard]] int find(const std::string& name) const;
};

[[nodiscard]] std::size_t ply_size(PlyType type);
/// Whether there is nothing there but what writers end a file with: a few blanks, line ends or zeros.
[[nodiscard]] bool is_blank(std::string_view rest);

/// Parses the header of `bytes`; `file` is for messages. Error{kInput} for anything that is no PLY 1.0, for
/// list properties of a vertex, for two properties of one name, and for a count of vertices that the rest of
/// the file can't hold. Elements in front of the vertices must have scalar properties alone.
[[nodiscard]] PlyHeader parse_ply_header(const std::string& bytes, const std::string& file);

}  // namespace simuli
