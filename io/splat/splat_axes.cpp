#include "io/splat/splat_axes.hpp"

#include <algorithm>
#include <cmath>

#include "host/core/base/error.hpp"
#include "host/core/scene/mounting.hpp"
#include "host/core/scene/placement.hpp"
#include "io/splat/ply.hpp"

namespace simuli {

Eigen::Quaterniond level_from(SplatAxes axes) {
  switch (axes) {
    case SplatAxes::kYDown:
      return kForwardFromCamera;
    case SplatAxes::kYUp:  // a rotation by 180 degrees about x first
      return kForwardFromCamera * Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);
    case SplatAxes::kZUp:
      break;
  }
  return Eigen::Quaterniond::Identity();
}

GaussianSet turned(const GaussianSet& set, const Eigen::Quaterniond& b_from_a) {
  GaussianSet out = set;
  if (std::abs(b_from_a.w()) < 1.0) transform(out, {b_from_a, Eigen::Vector3d::Zero()});
  return out;
}

float opacity_of(float logit) { return 1.0F / (1.0F + std::exp(-logit)); }

float logit_of(float opacity) {
  constexpr float kLeast = 0x1p-24F;  // distance from 1 to the next lower float
  const float share = std::clamp(opacity, kLeast, 1.0F - kLeast);
  return std::log(share / (1.0F - share));
}

float log_scale_of(float scale_m) {
  constexpr float kThinnest_m = 1e-9F;
  return std::log(std::max(scale_m, kThinnest_m));
}

Eigen::Vector4f unit_rotation(const GaussianSet& set, Eigen::Index particle) {
  return set.rotation().row(particle).transpose().stableNormalized();
}

void need_camera_set(const GaussianSet& set, const std::string& file) {
  validate(set, file);
  if (set.kind != SetKind::kCamera) throw_input_error(file, "kind", "a LiDAR set", "a camera set");
}

}  // namespace simuli
