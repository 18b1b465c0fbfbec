#pragma once
#include <string>

#include "host/core/scene/ground/triangle_mesh.hpp"

namespace simuli {

/// Returns a binary little-endian PLY: floats x, y, z and faces of three vertex_indices.
[[nodiscard]] std::string ply_of(const TriangleMesh& mesh);

}  // namespace simuli
