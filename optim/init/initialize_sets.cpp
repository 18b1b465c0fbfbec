#include "optim/init/initialize_sets.hpp"

#include <algorithm>
#include <cmath>

#include "host/core/base/error.hpp"
#include "host/core/base/linear_algebra.hpp"
#include "optim/init/points/surface_shapes.hpp"

namespace simuli {
namespace {

constexpr float kOpacityLogit = 0.0F;  // 0.5: the first steps can change it either way
/// Hit and drop logits of +-1.5: a hit probability of 0.95 with a useful gradient.
constexpr float kHitLogit = 1.5F;
constexpr float kUntaughtOpacityLogit = 2.0F;  // 0.88: no distance loss will raise it
constexpr float kUnseenOpacityLogit = 2.0F;    // 0.88, for particles without another particle at their place
constexpr float kFlat = 0.5F;                  // largest ratio of thickness to width
/// Standard deviation of a camera particle relative to the distance to its neighbours (docs/DECISIONS.md,
/// "Initialisation").
constexpr double kCameraScale = 0.5;
constexpr double kFlatRatio = 0.2;  // ratio of thickness to width of a planar particle
constexpr double kThinnest_m = 0.01;
constexpr double kShellFlatRatio = 0.1;
constexpr double kShellScale = 0.8;         // standard deviation relative to the spacing of its cells
constexpr float kShellOpacityLogit = 3.0F;  // 0.95

void set_shape(GaussianSet& set,
               Eigen::Index row,
               const Eigen::Vector3f& mean,
               const Eigen::Quaternionf& scene_from_local,
               const Eigen::Vector3d& scale_m) {
  const Eigen::Quaternionf& q = scene_from_local;
  set.mean().row(row) = mean.transpose();
  set.log_scale().row(row) = scale_m.array().log().matrix().cast<float>().transpose();
  set.rotation().row(row) << q.w(), q.x(), q.y(), q.z();
  set.opacity_logit()(row) = kOpacityLogit;
}

/// Sets a particle on point `i`, flat on planes: `per_spacing` times the distance to its neighbours, at least
/// `width_m`.
void set_on_point(GaussianSet& set,
                  const PointSet& points,
                  std::size_t i,
                  const LocalShape& shape,
                  double width_m,
                  double per_spacing,
                  const InitOptions& options) {
  const double scale_m = std::clamp(
      per_spacing * std::max<double>(shape.spacing_m, width_m), kLeastScale_m, options.max_scale_m);
  const double thickness_m =
      shape.planar ? std::min(scale_m, std::max(kFlatRatio * scale_m, kThinnest_m)) : scale_m;
  const auto row = static_cast<Eigen::Index>(i);
  set_shape(set, row, points.position.col(row), shape.scene_from_local, {scale_m, scale_m, thickness_m});
}

void set_colour(GaussianSet& set, std::size_t row, const Eigen::Vector3f& colour) {
  set.sh(0).row(static_cast<Eigen::Index>(row)) = ((colour.array() - 0.5F) / kSh0).matrix().transpose();
}

}  // namespace

GaussianSet lidar_set(const PointSet& points,
                      const std::vector<SurfaceCell>& cells,
                      double voxel_m,
                      const InitOptions& options) {
  GaussianSet set(SetKind::kLidar, options.lidar_sh_degree, static_cast<Eigen::Index>(cells.size()));
  const std::vector<SurfaceShape> shapes =
      surface_shapes(points, cells, {.voxel_m = voxel_m, .max_m = options.max_scale_m});
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    set_shape(set, row, cells[i].mean, shapes[i].scene_from_local, shapes[i].scale_m.cast<double>());
    set.sh(0).row(row) << (cells[i].intensity - 0.5F) / kSh0, kHitLogit / kSh0, -kHitLogit / kSh0;
  }
  return set;
}

/// Makes opaque LiDAR particles on points whose rays return, or drop.
static GaussianSet opaque_set(const PointSet& points, bool returns, const InitOptions& options) {
  GaussianSet set(SetKind::kLidar, options.lidar_sh_degree, static_cast<Eigen::Index>(points.size()));
  const std::vector<LocalShape> shapes = local_shapes(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    set_on_point(set, points, i, shapes[i], 0.0, kLidarScale, options);
    set.sh(0)(static_cast<Eigen::Index>(i), 0) = (points.intensity[i] - 0.5F) / kSh0;
  }
  const float hit_logit = returns ? kHitLogit : -kHitLogit;
  set.sh(0).col(1).setConstant(hit_logit / kSh0);
  set.sh(0).col(2).setConstant(-hit_logit / kSh0);
  set.opacity_logit().setConstant(kUntaughtOpacityLogit);
  return set;
}

GaussianSet dark_set(const PointSet& points, const InitOptions& options) {
  return opaque_set(points, false, options);
}

GaussianSet unmet_set(const PointSet& points, const InitOptions& options) {
  return opaque_set(points, true, options);
}

GaussianSet camera_set(const PointSet& points,
                       const std::vector<PointObservation>& observations,
                       const InitOptions& options) {
  GaussianSet set(SetKind::kCamera, options.camera_sh_degree, static_cast<Eigen::Index>(points.size()));
  const std::vector<LocalShape> shapes = local_shapes(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    set_on_point(set, points, i, shapes[i], observations[i].footprint_m, kCameraScale, options);
    set_colour(set, i, observations[i].colour);
  }
  return set;
}

GaussianSet unseen_set(const UnseenSurfaces& surfaces,
                       const std::vector<std::uint32_t>& kept,
                       const InitOptions& options) {
  GaussianSet set(SetKind::kCamera, options.camera_sh_degree, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t row = 0; row < kept.size(); ++row) {
    const SurfaceShape& shape = surfaces.shapes[kept[row]];
    set_shape(set,
              static_cast<Eigen::Index>(row),
              surfaces.cells[kept[row]].mean,
              shape.scene_from_local,
              shape.scale_m.cast<double>());
    set_colour(set, row, surfaces.colours[kept[row]]);
  }
  set.opacity_logit().setConstant(kUnseenOpacityLogit);
  return set;
}

std::vector<Eigen::Index> unseen_walls(const GaussianSet& start) {
  std::vector<Eigen::Index> out;
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    const auto sizes = start.log_scale().row(i);
    const bool is_flat = sizes.minCoeff() - sizes.maxCoeff() <= std::log(kFlat);
    if (is_flat && start.opacity_logit()(i) == kUnseenOpacityLogit) out.push_back(i);
  }
  return out;
}

GaussianSet shell_set(const FarShell& shell,
                      const std::vector<FarShell::Patch>& patches,
                      const std::vector<std::uint32_t>& kept,
                      const InitOptions& options) {
  GaussianSet set(SetKind::kCamera, options.camera_sh_degree, static_cast<Eigen::Index>(kept.size()));
  if (kept.empty()) return set;
  // Fewer patches than cells: each patch also covers cells that were left out.
  const double widened = std::sqrt(static_cast<double>(patches.size()) / static_cast<double>(kept.size()));
  // Wide and opaque: there is nothing behind the shell, and gaps would show in views without training pictures.
  const double scale_m = kShellScale * widened * shell.spacing_rad() * shell.distance_m();
  for (std::size_t row = 0; row < kept.size(); ++row) {
    const FarShell::Patch& patch = patches[kept[row]];
    set_shape(set,
              static_cast<Eigen::Index>(row),
              patch.direction * static_cast<float>(shell.distance_m()),
              turn_between(Eigen::Vector3d::UnitZ(), patch.direction.cast<double>()).cast<float>(),
              {scale_m, scale_m, kShellFlatRatio * scale_m});
    set.opacity_logit()(static_cast<Eigen::Index>(row)) = kShellOpacityLogit;
    set_colour(set, row, patch.colour);
  }
  return set;
}

void append(GaussianSet& to, const GaussianSet& others, std::uint32_t actor) {
  if (to.kind != others.kind || to.params.cols() != others.params.cols()) {
    throw Error(ErrorKind::kInternal, "append: sets of another kind or SH degree");
  }
  const auto count = static_cast<std::size_t>(to.size() + others.size());
  if (actor != 0 && to.actor.empty()) to.actor.assign(static_cast<std::size_t>(to.size()), 0);
  if (!to.actor.empty()) to.actor.resize(count, actor);
  to.params.conservativeResize(static_cast<Eigen::Index>(count), Eigen::NoChange);
  to.params.bottomRows(others.size()) = others.params;
}

}  // namespace simuli
