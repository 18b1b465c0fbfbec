#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace simuli {

struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;                // m
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

}  // namespace simuli
