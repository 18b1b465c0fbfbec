#include "host/core/scene/placement.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/linear_algebra.hpp"
#include "host/core/scene/edit.hpp"
#include "host/core/scene/particle_order.hpp"

namespace simuli {
namespace {

// The device's SH basis, compiled for the host.
namespace sh_text {
using F = double;
#define FN inline
#define R(x) x
#define SH_DEGREE 3
#include "cl/math/sh.h"
#undef FN
#undef R
#undef SH_DEGREE
#undef SH_COEFFICIENTS
#undef SH_HALF
#undef SH_ROW
#undef SH_ONE
#undef SH_LANES
}  // namespace sh_text

/// Evenly distributed directions, on which the basis has full rank.
std::vector<Eigen::Vector3d> directions() {
  constexpr int kCount = 64;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kCount, r = std::sqrt(1.0 - z * z);
    out.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return out;
}

/// [16, 16] coefficients in frame b of the unit coefficients in frame a: bands do not mix.
Eigen::MatrixXd turned_bands(const Eigen::Quaterniond& b_from_a) {
  const std::vector<Eigen::Vector3d> all = directions();
  Eigen::MatrixXd in_b(all.size(), 16), in_a(all.size(), 16);
  for (std::size_t i = 0; i < all.size(); ++i) {
    in_b.row(static_cast<Eigen::Index>(i)) = sh_basis_at(all[i]);
    in_a.row(static_cast<Eigen::Index>(i)) = sh_basis_at(b_from_a.conjugate() * all[i]);
  }
  Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(16, 16);
  for (int band = 0; band <= 3; ++band) {
    const int first = band * band, count = 2 * band + 1;
    const Eigen::MatrixXd of_band = in_b.middleCols(first, count);  // well conditioned
    turned.block(first, first, count, count) =
        pseudo_inverse<Eigen::MatrixXd>(of_band.transpose() * of_band) *
        (of_band.transpose() * in_a.middleCols(first, count));
  }
  return turned;
}

/// Fainter particles are fog and training residue.
constexpr float kFaintLogit = -2.2F;  // an opacity of 0.1
constexpr std::size_t kOneInEnds = 200;

/// Smallest side of a box.
constexpr double kThinnest_m = 1e-3;

/// As in optim/init: hit probability at initialisation.
constexpr float kHitLogit = 4.0F;

}  // namespace

Eigen::Matrix<double, 1, 16> sh_basis_at(const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 1, 16> out;
  sh_text::sh_basis(direction.x(), direction.y(), direction.z(), out.data());
  return out;
}

void transform(GaussianSet& set, const Pose& b_from_a, double scale) {
  if (!(scale > 0.0 && std::isfinite(scale))) {
    throw Error(ErrorKind::kUsage, fmt::format("scale: found {}, allowed above 0 and finite", scale));
  }
  const Eigen::Matrix3d turn = b_from_a.rotation.toRotationMatrix();
  const Eigen::Quaternionf q = b_from_a.rotation.cast<float>();
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const Eigen::Vector3d mean = set.mean().row(i).transpose().cast<double>();
    set.mean().row(i) = (turn * (scale * mean) + b_from_a.translation).cast<float>().transpose();
    const Eigen::Vector4f own = set.rotation().row(i).transpose();
    const Eigen::Quaternionf turned = q * Eigen::Quaternionf(own[0], own[1], own[2], own[3]);
    set.rotation().row(i) << turned.w(), turned.x(), turned.y(), turned.z();
  }
  set.log_scale().array() += static_cast<float>(std::log(scale));
  if (set.sh_degree == 0) return;
  const int count = sh_coefficients(set.sh_degree);
  const Eigen::MatrixXf bands = turned_bands(b_from_a.rotation).topLeftCorner(count, count).cast<float>();
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    Eigen::MatrixX3f sh(count, 3);
    for (int k = 0; k < count; ++k) sh.row(k) = set.sh(k).row(i);
    sh = (bands * sh).eval();
    for (int k = 0; k < count; ++k) set.sh(k).row(i) = sh.row(k);
  }
}

Eigen::AlignedBox3d extent_of(const GaussianSet& set) {
  Eigen::AlignedBox3d box;
  const bool all = (set.opacity_logit().array() < kFaintLogit).all();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<float> places;
    for (Eigen::Index i = 0; i < set.size(); ++i) {
      if (all || set.opacity_logit()(i) >= kFaintLogit) places.push_back(set.mean()(i, axis));
    }
    if (places.empty()) return box;
    const auto cut = static_cast<std::ptrdiff_t>(places.size() / kOneInEnds);
    std::nth_element(places.begin(), places.begin() + cut, places.end());
    box.min()[axis] = static_cast<double>(places[static_cast<std::size_t>(cut)]);
    std::nth_element(places.begin(), places.end() - 1 - cut, places.end());
    box.max()[axis] = static_cast<double>(*(places.end() - 1 - cut));
  }
  return box;
}

GaussianSet lidar_of(const GaussianSet& camera) {
  GaussianSet set(SetKind::kLidar, 0, camera.size());
  set.params.leftCols(kShRow) = camera.params.leftCols(kShRow);
  set.actor = camera.actor;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    const float light = std::clamp(0.5F + kSh0 * camera.sh(0).row(i).mean(), 0.0F, 1.0F);
    set.sh(0).row(i) << (light - 0.5F) / kSh0, kHitLogit / kSh0, -kHitLogit / kSh0;
  }
  return set;
}

Scene as_actor(const Scene& object, const std::string& name, const Pose& world_from_base) {
  Scene scene = object;
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    std::vector<Eigen::Index> still;
    for (Eigen::Index i = 0; i < set->size(); ++i) {
      if (set->actor.empty() || set->actor[static_cast<std::size_t>(i)] == 0) still.push_back(i);
    }
    *set = subset(*set, still);
  }
  const Eigen::AlignedBox3d box = extent_of(scene.camera.size() > 0 ? scene.camera : scene.lidar);
  if (box.isEmpty()) throw_input_error(object.name, "particles", "none", "at least one");
  const Eigen::RowVector3f middle = box.center().transpose().cast<float>();
  for (GaussianSet* set : {&scene.camera, &scene.lidar}) {
    set->mean().rowwise() -= middle;
    set->actor.assign(static_cast<std::size_t>(set->size()), 1);
  }
  Actor actor;
  actor.name = name;
  actor.kind = "object";
  actor.size_m = box.sizes().cwiseMax(kThinnest_m);
  const Pose world_from_middle =
      world_from_base * Pose{Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.5 * actor.size_m.z()}};
  constexpr double kAlways_s = 1e6;
  for (const double time_s : {-kAlways_s, kAlways_s}) actor.track.push_back({time_s, world_from_middle});
  scene.actors = {std::move(actor)};
  return scene;
}

}  // namespace simuli
