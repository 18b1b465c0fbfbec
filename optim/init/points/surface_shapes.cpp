#include "optim/init/points/surface_shapes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/core/base/parallel.hpp"
#include "optim/init/points/point_tree.hpp"

namespace simuli {
namespace {

using Eigen::Vector3f;

constexpr std::uint32_t kEnoughPoints = 6;  // points of a cell that define its own plane
/// Numbers of nearest points tried for a plane: more where they are all on one line, such as a row of returns.
constexpr std::array<std::size_t, 3> kNeighbours{9, 25, 65};
constexpr float kSurfacePlaneRatio = 0.1F;  // largest ratio of smallest to middle variance of a plane
constexpr float kSurfaceLineRatio = 0.02F;  // largest ratio of middle to largest variance of a line
constexpr float kGapReach = 1.5F;  // largest distance of the next particle relative to the sweep's spacing
constexpr float kOffPlane = 0.2F;  // largest distance from the plane relative to that distance

struct Plane {
  enum class Kind { kNone, kLine, kPlane } kind = Kind::kNone;
  Vector3f normal = Vector3f::UnitZ();
  float thickness_m = 0.0F;
};

Plane plane_of(const Eigen::Matrix3f& covariance) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance.cast<double>());
  const Vector3f variance = solver.eigenvalues().cast<float>().cwiseMax(0.0F);  // ascending
  Plane out;
  out.normal = solver.eigenvectors().col(0).cast<float>();
  out.thickness_m = std::sqrt(variance(0));
  if (!(variance(1) >= kSurfaceLineRatio * variance(2) && variance(1) > 0.0F)) {
    out.kind = Plane::Kind::kLine;
  } else if (variance(0) <= kSurfacePlaneRatio * variance(1)) {
    out.kind = Plane::Kind::kPlane;
  }
  return out;
}

PointSet means_of(const std::vector<SurfaceCell>& cells) {
  PointSet out;
  out.position.resize(3, static_cast<Eigen::Index>(cells.size()));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    out.position.col(static_cast<Eigen::Index>(i)) = cells[i].mean;
    out.intensity.push_back(cells[i].intensity);
  }
  return out;
}

/// Points with a search tree.
class Cloud {
 public:
  explicit Cloud(const PointSet& points)
      : points_(points), tree_(3, view_, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {
    if (points.size() > 0) tree_.buildIndex();
  }
  [[nodiscard]] Vector3f at(std::uint32_t i) const {
    return points_.position.col(static_cast<Eigen::Index>(i));
  }
  /// Covariance of the `count` points nearest to p; zero for fewer than four, which are always coplanar.
  [[nodiscard]] Eigen::Matrix3f covariance_around(const Vector3f& p, std::size_t count) const {
    std::array<std::uint32_t, kNeighbours.back()> index{};
    std::array<float, kNeighbours.back()> distance2{};
    const std::size_t found = tree_.knnSearch(p.data(), count, index.data(), distance2.data());
    Eigen::Matrix3f out = Eigen::Matrix3f::Zero();
    if (found < 4) return out;
    Vector3f mean = Vector3f::Zero();
    for (std::size_t k = 0; k < found; ++k) mean += at(index[k]) - p;
    mean /= static_cast<float>(found);
    for (std::size_t k = 0; k < found; ++k) {
      const Vector3f d = at(index[k]) - p - mean;
      out += d * d.transpose();
    }
    return out / static_cast<float>(found);
  }
  /// Mean distance from point p of the cloud to its nearest neighbours; +inf without any.
  [[nodiscard]] float spacing_m(const Vector3f& p) const {
    std::array<std::uint32_t, kSpacingNeighbours + 1> index{};
    std::array<float, kSpacingNeighbours + 1> distance2{};
    const std::size_t found = tree_.knnSearch(p.data(), index.size(), index.data(), distance2.data());
    float sum = 0.0F;
    for (std::size_t k = 1; k < found; ++k) sum += std::sqrt(distance2[k]);
    return found > 1 ? sum / static_cast<float>(found - 1) : std::numeric_limits<float>::infinity();
  }
  template <class F>
  void for_each_within(const Vector3f& p, float radius_m, F&& f) const {
    simuli::for_each_within(tree_, p.data(), radius_m, f);
  }

 private:
  const PointSet& points_;
  CloudView view_{points_};
  PointTree tree_;
};

/// Sampling axes of a plane and the spacing of one sweep's samples along them.
struct Lattice {
  Vector3f axis[2];
  float step_m[2];
};

Lattice lattice_on(const Vector3f& normal, const Sight& sight) {
  const Vector3f first = normal.unitOrthogonal(), second = normal.cross(first);
  Lattice out{{first, second}, {0.0F, 0.0F}};
  if (!sight.is_known()) return out;
  const Vector3f steps[] = {sight.column_step_on(normal), sight.row_step_on(normal)};
  Eigen::Matrix2f spread = Eigen::Matrix2f::Zero();
  for (const Vector3f& step : steps) {
    const Eigen::Vector2f flat(first.dot(step), second.dot(step));
    spread += flat * flat.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> solver;
  solver.computeDirect(spread);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2f along = solver.eigenvectors().col(1 - k);  // the sparse axis first
    out.axis[k] = along.x() * first + along.y() * second;
    out.step_m[k] = std::sqrt(std::max(0.0F, solver.eigenvalues()(1 - k)));
  }
  return out;
}

class Shaper {
 public:
  Shaper(const PointSet& points, const std::vector<SurfaceCell>& cells, const ShapeOptions& options)
      : cells_(cells), options_(options), means_(means_of(cells)), cloud_(points), neighbours_(means_) {}

  [[nodiscard]] SurfaceShape shape(std::size_t i) const {
    const SurfaceCell& cell = cells_[i];
    const Plane plane = plane_at(cell);
    return plane.kind == Plane::Kind::kPlane ? flat(cell, plane) : round(cell);
  }

 private:
  [[nodiscard]] float voxel_m() const { return static_cast<float>(options_.voxel_m); }

  [[nodiscard]] Plane plane_at(const SurfaceCell& cell) const {
    Plane plane;
    if (cell.points >= kEnoughPoints) plane = plane_of(cell.covariance);
    for (std::size_t k = 0; k < kNeighbours.size() && plane.kind != Plane::Kind::kPlane; ++k) {
      if (k > 0 && plane.kind == Plane::Kind::kNone) break;
      plane = plane_of(cloud_.covariance_around(cell.mean, kNeighbours[k]));
    }
    return plane;
  }

  /// Extent of the cell along an axis: the squared side of a uniform square is 12 times its variance.
  [[nodiscard]] float extent_m(const SurfaceCell& cell, const Vector3f& axis) const {
    return std::sqrt(12.0F * std::max(0.0F, axis.dot(cell.covariance * axis)) + voxel_m() * voxel_m());
  }

  /// Distances to the next particles along both axes, the mean of both sides; 0: none.
  [[nodiscard]] std::array<float, 2> gaps_m(const SurfaceCell& cell,
                                            const Vector3f& normal,
                                            const Lattice& lattice) const {
    const float most_m = static_cast<float>(options_.max_m / options_.scale);
    float reach[2], nearest[2][2];
    for (int k = 0; k < 2; ++k) {
      reach[k] = std::min(kGapReach * std::max(lattice.step_m[k], voxel_m()), most_m);
      nearest[k][0] = nearest[k][1] = std::numeric_limits<float>::infinity();
    }
    neighbours_.for_each_within(cell.mean, std::max(reach[0], reach[1]), [&](std::uint32_t other) {
      const Vector3f d = neighbours_.at(other) - cell.mean;
      if (std::abs(normal.dot(d)) > kOffPlane * d.norm() + 0.5F * voxel_m()) return;
      const float along[2] = {lattice.axis[0].dot(d), lattice.axis[1].dot(d)};
      const int k = std::abs(along[0]) * reach[1] > std::abs(along[1]) * reach[0] ? 0 : 1;
      const float far = std::abs(along[k]);
      float& side = nearest[k][along[k] > 0.0F ? 0 : 1];
      if (far > 0.0F && far <= reach[k]) side = std::min(side, far);
    });
    std::array<float, 2> out{};
    for (std::size_t k = 0; k < 2; ++k) {
      float sum = 0.0F, sides = 0.0F;
      for (const float m : nearest[k]) {
        if (std::isfinite(m)) sum += m, sides += 1.0F;
      }
      if (sides > 0.0F) out[k] = sum / sides;
    }
    return out;
  }

  [[nodiscard]] float clamped(float scale_m) const {
    return std::clamp(scale_m, static_cast<float>(options_.min_m), static_cast<float>(options_.max_m));
  }

  [[nodiscard]] SurfaceShape flat(const SurfaceCell& cell, const Plane& plane) const {
    const Lattice lattice = lattice_on(plane.normal, cell.sight);
    std::array<float, 2> width{extent_m(cell, lattice.axis[0]), extent_m(cell, lattice.axis[1])};
    if (!cell.sight.is_known()) {
      const float spacing = neighbours_.spacing_m(cell.mean);
      if (std::isfinite(spacing))
        for (float& w : width) w = std::max(w, spacing);
    } else if (lattice.step_m[0] > width[0] || lattice.step_m[1] > width[1]) {
      const std::array<float, 2> gap = gaps_m(cell, plane.normal, lattice);
      for (std::size_t k = 0; k < 2; ++k) width[k] = std::max(width[k], gap[k]);
    }
    const auto scale = static_cast<float>(options_.scale);
    SurfaceShape out;
    out.planar = true;
    out.scale_m << clamped(scale * width[0]), clamped(scale * width[1]), 0.0F;
    out.scale_m.z() = std::min(std::max(plane.thickness_m, static_cast<float>(options_.thin_m)),
                               out.scale_m.head<2>().minCoeff());
    Eigen::Matrix3f scene_from_local;
    scene_from_local << lattice.axis[0], plane.normal.cross(lattice.axis[0]), plane.normal;
    out.scene_from_local = Eigen::Quaternionf(scene_from_local).normalized();
    return out;
  }

  [[nodiscard]] SurfaceShape round(const SurfaceCell& cell) const {
    const auto scale = static_cast<float>(options_.scale);
    SurfaceShape out;
    if (cell.points >= kEnoughPoints) {
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
      solver.computeDirect(cell.covariance);
      Eigen::Matrix3f axes = solver.eigenvectors();
      if (axes.determinant() < 0.0F) axes.col(0) = -axes.col(0);
      for (int k = 0; k < 3; ++k) out.scale_m(k) = clamped(scale * extent_m(cell, axes.col(k)));
      out.scene_from_local = Eigen::Quaternionf(axes).normalized();
      return out;
    }
    float most_m = std::numeric_limits<float>::infinity();
    if (cell.sight.is_known()) {
      most_m = kGapReach * cell.sight.range_m *
               std::max(cell.sight.column_step.norm(), cell.sight.row_step.norm());
    }
    const float width = std::max(std::min(neighbours_.spacing_m(cell.mean), most_m), voxel_m());
    out.scale_m.setConstant(clamped(scale * width));
    return out;
  }

  const std::vector<SurfaceCell>& cells_;
  const ShapeOptions& options_;
  PointSet means_;
  Cloud cloud_, neighbours_;
};

}  // namespace

std::vector<SurfaceShape> surface_shapes(const PointSet& points,
                                         const std::vector<SurfaceCell>& cells,
                                         const ShapeOptions& options) {
  std::vector<SurfaceShape> out(cells.size());
  if (cells.empty()) return out;
  const Shaper shaper(points, cells, options);
  parallel_each(cells.size(), [&](std::size_t i) { out[i] = shaper.shape(i); });
  return out;
}

}  // namespace simuli
