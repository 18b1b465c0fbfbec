#include "optim/init/initialize_unseen.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nanoflann.hpp>

#include "host/core/base/parallel.hpp"

namespace simuli {
namespace {

constexpr std::size_t kNeighbours = 64;
// Weights of dissimilarity, in equivalent metres of distance: a surface rotated by 90 degrees, full intensity
// difference, and per metre of height.
constexpr float kTurned_m = 5.0F, kBrighter_m = 30.0F, kHigher = 4.0F;
constexpr float kBlur_m = 0.5F;  // smaller distances do not increase the weight
// Points that may lend a colour: many pictures, consistent colours. Between two rows of returns at the rear of
// a parked car a picture can assign the car's colour to the road; points in few or inconsistent pictures often
// have the colour of another surface.
constexpr std::uint32_t kWitnesses = 3;
constexpr float kAlike = 0.25F;  // largest difference of a channel between pictures, of [0, 1]
// Finer cells than the LiDAR set's, because borders between colours are visible; wider particles, because no
// training closes gaps.
constexpr double kFlatSide_m = 0.2;
constexpr double kCellScale = 0.7;  // standard deviation relative to the spacing

/// Selects views at least `least_m` apart.
std::vector<const ImageView*> apart(const std::vector<ImageView>& views, double least_m) {
  std::vector<const ImageView*> some;
  for (const ImageView& view : views) {
    const auto is_near = [&](const ImageView* other) {
      return (other->origin() - view.origin()).norm() < least_m && other->camera().name == view.camera().name;
    };
    if (std::none_of(some.begin(), some.end(), is_near)) some.push_back(&view);
  }
  return some;
}

/// Camera positions moved by off_path_m to either side and upwards, and the original one.
std::array<Eigen::Vector3d, 4> moves_of(const ImageView& view, double off_path_m) {
  const Camera& camera = view.camera();
  Eigen::Vector3d origin, forward;
  view.unproject({0.5 * camera.width, 0.5 * camera.height}, origin, forward);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d left =
      up.cross(forward).normalized();  // zero for a camera that observations straight down
  return {Eigen::Vector3d::Zero(), off_path_m * left, -off_path_m * left, off_path_m * up};
}

/// Tests whether any view, at its position or moved, has a point in its picture.
class MovedViews {
 public:
  MovedViews(const std::vector<ImageView>& views, double off_path_m) : some_(apart(views, 0.5 * off_path_m)) {
    for (const ImageView* view : some_) moves_.push_back(moves_of(*view, off_path_m));
  }
  [[nodiscard]] bool show(const Eigen::Vector3d& p_scene) const {
    for (std::size_t v = 0; v < some_.size(); ++v) {
      for (const Eigen::Vector3d& move : moves_[v]) {
        Eigen::Vector2d pixel;
        double range_m = 0.0;
        if (some_[v]->project(p_scene - move, pixel, range_m)) return true;
      }
    }
    return false;
  }

 private:
  std::vector<const ImageView*> some_;
  std::vector<std::array<Eigen::Vector3d, 4>> moves_;
};

/// Feature vector of position, intensity and normal, whose distances measure dissimilarity in m.
constexpr int kLikeness = 10;
using Likeness = Eigen::Matrix<float, 1, kLikeness>;
using Likenesses = Eigen::Matrix<float, Eigen::Dynamic, kLikeness, Eigen::RowMajor>;
using LikenessTree = nanoflann::KDTreeEigenMatrixAdaptor<Likenesses, kLikeness, nanoflann::metric_L2_Simple>;

Likeness likeness(const Eigen::Vector3f& p,
                  float intensity,
                  bool planar,
                  const Eigen::Quaternionf& scene_from_local) {
  // A normal's sign is arbitrary, so its outer product is used. Non-planar points have an isotropic one.
  Eigen::Matrix3f facing = Eigen::Matrix3f::Identity() / 3.0F;
  if (planar) {
    const Eigen::Vector3f n = scene_from_local * Eigen::Vector3f::UnitZ();
    facing = n * n.transpose();
  }
  const float diagonal = kTurned_m / std::sqrt(2.0F);
  Likeness out;
  out << p.x(), p.y(), kHigher * p.z(), kBrighter_m * intensity, diagonal * facing(0, 0),
      diagonal * facing(1, 1), diagonal * facing(2, 2), kTurned_m * facing(0, 1), kTurned_m * facing(0, 2),
      kTurned_m * facing(1, 2);
  return out;
}

/// Returns the points that may lend their colour: `seen` without points in few pictures, unless all are.
std::vector<std::uint32_t> lenders_of(const std::vector<std::uint32_t>& seen,
                                      const std::vector<PointObservation>& observations,
                                      std::size_t views) {
  const auto least = static_cast<std::uint32_t>(std::min<std::size_t>(kWitnesses, views));
  std::vector<std::uint32_t> out;
  for (const std::uint32_t i : seen) {
    const PointObservation& look = observations[i];
    if (look.images >= least && look.colours.sizes().maxCoeff() < kAlike) out.push_back(i);
  }
  return out.empty() ? seen : out;
}

/// Returns the mean colour of the most similar points.
Eigen::Vector3f colour_alike(const Likeness& query,
                             const LikenessTree& tree,
                             const std::vector<Eigen::Vector3f>& colours) {
  std::array<Eigen::Index, kNeighbours> index{};
  std::array<float, kNeighbours> distance2{};
  const std::size_t found = tree.index->knnSearch(query.data(), kNeighbours, index.data(), distance2.data());
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float total = 0.0F;
  for (std::size_t k = 0; k < found; ++k) {
    const float weight = std::pow(distance2[k] + kBlur_m * kBlur_m, -1.5F);
    sum += weight * colours[static_cast<std::size_t>(index[k])];
    total += weight;
  }
  return sum / total;
}

}  // namespace

UnseenSurfaces unseen_surfaces(const PointSet& points,
                               const std::vector<PointObservation>& observations,
                               const std::vector<ImageView>& views,
                               const InitOptions& options) {
  std::vector<std::uint32_t> seen, unseen;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    (std::isfinite(observations[i].range_m) ? seen : unseen).push_back(static_cast<std::uint32_t>(i));
  }
  UnseenSurfaces out;
  if (seen.empty() || !(options.off_path_m > 0.0)) return out;

  const MovedViews moved(views, options.off_path_m);
  std::vector<std::uint8_t> shown(unseen.size());
  parallel_each(unseen.size(), [&](std::size_t k) {
    shown[k] = moved.show(points.position.col(unseen[k]).cast<double>()) ? 1 : 0;
  });
  std::vector<std::uint32_t> kept;
  for (std::size_t k = 0; k < unseen.size(); ++k) {
    if (shown[k] != 0) kept.push_back(unseen[k]);
  }
  if (kept.empty()) return out;
  const PointSet own = points.subset(kept);
  out.points = own.size();
  CellOptions cells = kLidarCells;
  cells.voxel_m = options.voxel_m;
  cells.flat_side_m = kFlatSide_m;
  out.cells = surface_cells(own, cells);
  out.shapes = surface_shapes(
      own, out.cells, {.voxel_m = options.voxel_m, .scale = kCellScale, .max_m = options.max_scale_m});

  const std::vector<LocalShape> shapes = local_shapes(points);
  const std::vector<std::uint32_t> lenders = lenders_of(seen, observations, views.size());
  std::vector<Eigen::Vector3f> colours;
  Likenesses known(static_cast<Eigen::Index>(lenders.size()), kLikeness);
  for (std::size_t k = 0; k < lenders.size(); ++k) {
    const std::uint32_t i = lenders[k];
    colours.push_back(observations[i].colour);
    known.row(static_cast<Eigen::Index>(k)) =
        likeness(points.position.col(i), points.intensity[i], shapes[i].planar, shapes[i].scene_from_local);
  }
  const LikenessTree tree(kLikeness, known, 16);
  out.colours.resize(out.cells.size());
  parallel_each(out.cells.size(), [&](std::size_t k) {
    const SurfaceCell& cell = out.cells[k];
    const SurfaceShape& shape = out.shapes[k];
    out.colours[k] = colour_alike(
        likeness(cell.mean, cell.intensity, shape.planar, shape.scene_from_local), tree, colours);
  });
  return out;
}

}  // namespace simuli
