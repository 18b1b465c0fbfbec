#pragma once
// Names that reader and writer of Gaussian PLY files share, for io/splat/ply_*.cpp.
#include <string>
#include <utility>
#include <vector>

#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// Returns the header comment that names the three channels of a set.
[[nodiscard]] inline std::string ply_channels_comment(SetKind kind) {
  return kind == SetKind::kLidar ? "simuli channels intensity hit_logit drop_logit"
                                 : "simuli channels red green blue";
}

/// Property of sets with actors: GaussianSet::actor.
inline constexpr const char* kPlyActor = "actor";

/// Returns the property names of a set in the standard order (without normals) with their columns in
/// GaussianSet::params. f_rest is channel-major: all higher coefficients of the first channel are first.
[[nodiscard]] inline std::vector<std::pair<std::string, int>> ply_gaussian_columns(int sh_degree) {
  std::vector<std::pair<std::string, int>> columns{{"x", kMeanRow}, {"y", kMeanRow + 1}, {"z", kMeanRow + 2}};
  for (int c = 0; c < 3; ++c) columns.emplace_back("f_dc_" + std::to_string(c), kShRow + c);
  const int higher = sh_coefficients(sh_degree) - 1;
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < higher; ++k) {
      columns.emplace_back("f_rest_" + std::to_string(c * higher + k), kShRow + 3 * (k + 1) + c);
    }
  }
  columns.emplace_back("opacity", kOpacityRow);
  for (int i = 0; i < 3; ++i) columns.emplace_back("scale_" + std::to_string(i), kLogScaleRow + i);
  for (int i = 0; i < 4; ++i) columns.emplace_back("rot_" + std::to_string(i), kRotationRow + i);
  return columns;
}

}  // namespace simuli
