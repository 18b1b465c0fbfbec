// Trees and hedges of the detailed street: many small clumps of leaves with gaps.
#include <cmath>
#include <numbers>

#include "bench/street/detail.hpp"

namespace simuli::bench {
namespace {

using Eigen::Vector3d;

constexpr double kLeafReflectance = 0.45;

/// Varies the colour of a tree's clumps.
Vector3d leaf_tint(StreetSide& to, const Vector3d& tint) {
  return tint * to.between(0.6, 1.4) + Vector3d(to.between(-0.03, 0.05), to.between(-0.03, 0.03), 0.0);
}

}  // namespace

void add_detail_tree(StreetSide& to, const StreetSolid& trunk) {
  const double x = trunk.centre.x(), y = std::abs(trunk.centre.y()), top = trunk.high.z();
  const Vector3d bark(0.34, 0.26, 0.20);
  const Vector3d leaf(to.between(0.18, 0.36), to.between(0.36, 0.52), to.between(0.12, 0.22));
  const double reach = to.between(1.0, 1.4), tall = to.between(1.7, 2.6);
  const bool is_dense = to.chance(0.5);
  const int boughs = 5 + static_cast<int>(to.variety(3));
  const double turn = to.between(0.0, 2.0 * std::numbers::pi);
  for (int i = 0; i < boughs; ++i) {
    const double angle = turn + 2.0 * std::numbers::pi * i / boughs + to.between(-0.3, 0.3);
    const double share = (i + 0.5) / boughs;  // share of the crown's height: a spiral up the trunk
    const double out = reach * std::sin(std::numbers::pi * (0.25 + 0.6 * share)) * to.between(0.7, 1.0);
    const Vector3d from(x, y, top - 0.45 + 0.5 * share);
    const Vector3d end(x + out * std::cos(angle), y + out * std::sin(angle), top + tall * share);
    to.of(StreetMaterial::kBark, bark, 0.2).rod(from, end, to.between(0.035, 0.06));
    for (int twig = 0; twig < 4; ++twig) {
      const Vector3d fork = from + to.between(0.45, 0.8) * (end - from);
      const Vector3d tip =
          end + Vector3d(to.between(-0.55, 0.55), to.between(-0.55, 0.55), to.between(-0.25, 0.55));
      to.of(StreetMaterial::kBark, bark, 0.2).rod(fork, tip, to.between(0.012, 0.022));
      const int clumps = (is_dense ? 22 : 13) + static_cast<int>(to.variety(6));
      for (int k = 0; k < clumps; ++k) {
        const double spread = 0.52;
        to.of(StreetMaterial::kLeaves, leaf_tint(to, leaf), kLeafReflectance)
            .ball(tip.x() + to.between(-spread, spread),
                  tip.y() + to.between(-spread, spread),
                  tip.z() + to.between(-spread, spread),
                  to.between(0.08, is_dense ? 0.20 : 0.16));
      }
    }
  }
  // A square of bare earth around the trunk, and a guard of thin bars for some trees.
  constexpr double kHalf_m = 0.55;
  to.of(StreetMaterial::kShade, {0.26, 0.21, 0.16}, 0.2, 2)
      .box(x - kHalf_m, x + kHalf_m, y - 0.4, y + kHalf_m, 0.0, kKerbHeight_m + 0.01);
  if (!to.chance(0.35)) return;
  for (int i = 0; i < 8; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 8.0;
    to.of(StreetMaterial::kPainted, {0.16, 0.20, 0.18}, 0.3)
        .pole(x + 0.36 * std::cos(angle), y + 0.36 * std::sin(angle), kKerbHeight_m, 1.55, 0.011);
  }
}

void add_detail_hedge(StreetSide& to, double x0, double x1, double y0, double y1, double z0, double z1) {
  const Vector3d leaf(to.between(0.14, 0.26), to.between(0.32, 0.44), to.between(0.12, 0.18));
  // Leaves around a dark core.
  const double in = 0.3 * (y1 - y0);
  if (x1 - x0 > 2.5 * in && z1 - z0 > 0.4) {
    to.of(StreetMaterial::kLeaves, 0.45 * leaf, 0.3).box(x0 + in, x1 - in, y0 + in, y1 - in, z0, z1 - 0.12);
  }
  constexpr double kStep_m = 0.27;
  for (double x = x0 + 0.1; x < x1; x += kStep_m) {
    for (double z = z0 + 0.12; z < z1; z += kStep_m) {
      for (const double y : {y0 + 0.12, y1 - 0.12}) {
        to.of(StreetMaterial::kLeaves, leaf_tint(to, leaf), kLeafReflectance)
            .ball(x + to.between(-0.09, 0.09),
                  y + to.between(-0.06, 0.06),
                  z + to.between(-0.08, 0.08),
                  to.between(0.12, 0.21));
      }
    }
  }
}

}  // namespace simuli::bench
