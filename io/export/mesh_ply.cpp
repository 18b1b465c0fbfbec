#include "io/export/mesh_ply.hpp"

#include <bit>
#include <fmt/format.h>

#include "io/base/bytes.hpp"

namespace simuli {

std::string ply_of(const TriangleMesh& mesh) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\nelement face {}\n"
      "property list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(),
      mesh.triangles.size());
  for (const Eigen::Vector3f& v : mesh.vertices) {
    for (int c = 0; c < 3; ++c) append_little_endian(out, std::bit_cast<std::uint32_t>(v[c]), 4);
  }
  for (const auto& triangle : mesh.triangles) {
    append_little_endian(out, triangle.size(), 1);
    for (const std::uint32_t vertex : triangle) append_little_endian(out, vertex, 4);
  }
  return out;
}

}  // namespace simuli
