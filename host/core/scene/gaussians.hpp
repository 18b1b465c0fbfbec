#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace simuli {

/// Rows of the parameter matrix on host and device (SIM_MEAN.. of cl/shared/layout.h). SH coefficient k of
/// channel c is row kShRow + 3 k + c.
enum ParamRow : int { kMeanRow = 0, kLogScaleRow = 3, kRotationRow = 6, kOpacityRow = 10, kShRow = 11 };

/// Channels of the camera set: linear-free sRGB colour in [0,1] (0.5 + SH). Of the LiDAR set:
/// intensity in [0,1] (0.5 + SH), hit logit (SH), drop logit (SH).
enum class SetKind { kCamera, kLidar };

[[nodiscard]] constexpr int sh_coefficients(int degree) { return (degree + 1) * (degree + 1); }
[[nodiscard]] constexpr int param_rows(int sh_degree) { return kShRow + 3 * sh_coefficients(sh_degree); }

/// One set of 3D Gaussians: a column-major matrix with one particle per row and one parameter per
/// column, so that each parameter is contiguous. Means are metres from Scene::origin; log-scales are
/// ln(m); rotations (w,x,y,z), not necessarily normalised; opacity is a logit.
struct GaussianSet {
  SetKind kind = SetKind::kCamera;
  int sh_degree = 0;
  Eigen::MatrixXf params;  // [N, param_rows(sh_degree)]
  /// [N] owner of each particle: 0 for the background, i + 1 for Scene::actors[i], in whose frame its
  /// parameters are; then visibility sets, disoccluded and inpainted sets (occluders.hpp). Empty: all
  /// background.
  std::vector<std::uint32_t> actor;

  GaussianSet() = default;
  GaussianSet(SetKind set_kind, int degree, Eigen::Index count)
      : kind(set_kind), sh_degree(degree), params(Eigen::MatrixXf::Zero(count, param_rows(degree))) {}

  [[nodiscard]] Eigen::Index size() const { return params.rows(); }
  [[nodiscard]] auto mean() { return params.middleCols<3>(kMeanRow); }
  [[nodiscard]] auto mean() const { return params.middleCols<3>(kMeanRow); }
  [[nodiscard]] auto log_scale() { return params.middleCols<3>(kLogScaleRow); }
  [[nodiscard]] auto log_scale() const { return params.middleCols<3>(kLogScaleRow); }
  [[nodiscard]] auto rotation() { return params.middleCols<4>(kRotationRow); }
  [[nodiscard]] auto rotation() const { return params.middleCols<4>(kRotationRow); }
  [[nodiscard]] auto opacity_logit() { return params.col(kOpacityRow); }
  [[nodiscard]] auto opacity_logit() const { return params.col(kOpacityRow); }
  [[nodiscard]] auto sh(int coefficient) { return params.middleCols<3>(kShRow + 3 * coefficient); }
  [[nodiscard]] auto sh(int coefficient) const { return params.middleCols<3>(kShRow + 3 * coefficient); }
};

/// Y_00: feature = bias + kSh0 * sh(0) + ...
inline constexpr float kSh0 = 0.28209479177387814F;

}  // namespace simuli
