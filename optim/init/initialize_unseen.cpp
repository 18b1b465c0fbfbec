#include "optim/init/initialize_unseen.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nanoflann.hpp>

#include "host/base/parallel.hpp"

namespace simuli {
namespace {

constexpr std::size_t kNeighbours = 64;
// What makes points as unlike as so many metres between them: a quarter turn of their surface, all of the
// intensity there is, a metre of height.
constexpr float kTurned_m = 5.0F, kBrighter_m = 30.0F, kHigher = 4.0F;
constexpr float kBlur_m = 0.5F;  // what is nearer does not count for more

/// Views far enough apart that one between two of them would show little else.
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

/// Where a camera would be that is off_path_m to either side, or above; or where it was.
std::array<Eigen::Vector3d, 4> moves_of(const ImageView& view, double off_path_m) {
  const Camera& camera = view.camera();
  Eigen::Vector3d origin, forward;
  view.unproject({0.5 * camera.width, 0.5 * camera.height}, origin, forward);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d left = up.cross(forward).normalized();  // zero of a camera that looks straight down
  return {Eigen::Vector3d::Zero(), off_path_m * left, -off_path_m * left, off_path_m * up};
}

/// Where points lie, how they reflect and how they face, such that the distance of two tells how unlike they
/// are, m. [points]
constexpr int kLikeness = 10;
using Likeness = Eigen::Matrix<float, Eigen::Dynamic, kLikeness, Eigen::RowMajor>;
using LikenessTree = nanoflann::KDTreeEigenMatrixAdaptor<Likeness, kLikeness, nanoflann::metric_L2_Simple>;

Likeness likeness_of(const PointSet& points,
                     const std::vector<LocalShape>& shapes,
                     const std::vector<std::uint32_t>& some) {
  Likeness out(static_cast<Eigen::Index>(some.size()), kLikeness);
  for (std::size_t k = 0; k < some.size(); ++k) {
    const std::uint32_t i = some[k];
    const Eigen::Vector3f p = points.position.col(i);
    // A normal's sign says nothing: its products with itself. What is no plane faces all ways alike.
    const Eigen::Vector3f n = shapes[i].scene_from_local * Eigen::Vector3f::UnitZ();
    Eigen::Matrix3f facing = Eigen::Matrix3f::Identity() / 3.0F;
    if (shapes[i].planar) facing = n * n.transpose();
    const float diagonal = kTurned_m / std::sqrt(2.0F);
    out.row(static_cast<Eigen::Index>(k)) << p.x(), p.y(), kHigher * p.z(), kBrighter_m * points.intensity[i],
        diagonal * facing(0, 0), diagonal * facing(1, 1), diagonal * facing(2, 2), kTurned_m * facing(0, 1),
        kTurned_m * facing(0, 2), kTurned_m * facing(1, 2);
  }
  return out;
}

/// The mean colour of what is most alike.
Eigen::Vector3f colour_alike(const float* query,
                             const LikenessTree& tree,
                             const std::vector<Eigen::Vector3f>& colours) {
  std::array<Eigen::Index, kNeighbours> index{};
  std::array<float, kNeighbours> distance2{};
  const std::size_t found = tree.index->knnSearch(query, kNeighbours, index.data(), distance2.data());
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

UnseenPoints unseen_points(const PointSet& points,
                           const std::vector<PointLook>& looks,
                           const std::vector<ImageView>& views,
                           double off_path_m) {
  std::vector<std::uint32_t> seen, unseen;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    (std::isfinite(looks[i].range_m) ? seen : unseen).push_back(static_cast<std::uint32_t>(i));
  }
  UnseenPoints out;
  if (seen.empty() || !(off_path_m > 0.0)) return out;

  std::vector<PointLook> near(unseen.size());
  const std::vector<const ImageView*> some = apart(views, 0.5 * off_path_m);
  std::vector<std::array<Eigen::Vector3d, 4>> moves;
  for (const ImageView* view : some) moves.push_back(moves_of(*view, off_path_m));
  parallel_ranges(unseen.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Eigen::Vector3d p = points.position.col(unseen[k]).cast<double>();
      for (std::size_t v = 0; v < some.size(); ++v) {
        for (const Eigen::Vector3d& move : moves[v]) {
          Eigen::Vector2d pixel;
          double range_m = 0.0;
          if (!some[v]->project(p - move, pixel, range_m) || range_m >= near[k].range_m) continue;
          near[k].range_m = static_cast<float>(range_m);
          near[k].footprint_m = static_cast<float>(range_m * some[v]->pixel_size_at_1m());
        }
      }
    }
  });

  const std::vector<LocalShape> shapes = local_shapes(points);
  std::vector<Eigen::Vector3f> colours;
  for (const std::uint32_t i : seen) colours.push_back(looks[i].colour);
  const Likeness known = likeness_of(points, shapes, seen);
  const LikenessTree tree(kLikeness, known, 16);
  std::vector<std::uint32_t> kept;
  for (std::size_t k = 0; k < unseen.size(); ++k) {
    if (!std::isfinite(near[k].range_m)) continue;
    kept.push_back(unseen[k]);
    out.looks.push_back(near[k]);
  }
  const Likeness wanted = likeness_of(points, shapes, kept);
  parallel_ranges(kept.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      out.looks[k].colour = colour_alike(wanted.row(static_cast<Eigen::Index>(k)).data(), tree, colours);
    }
  });
  out.points = points.subset(kept);
  return out;
}

}  // namespace simuli
