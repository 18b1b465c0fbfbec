#include "optim/init/initialize_unseen.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/parallel.hpp"
#include "optim/points/point_tree.hpp"

namespace simuli {
namespace {

constexpr std::size_t kNeighbours = 8;
constexpr float kAlike = 0.1F;        // of intensity: neighbours that differ by more hardly count
constexpr float kLeastAlike = 1e-3F;  // but where there is no other, they do
constexpr float kBlur_m = 0.05F;      // nearer neighbours do not count for more

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

Eigen::Vector3f colour_near(const Eigen::Vector3f& point,
                            float intensity,
                            const PointTree& tree,
                            const PointSet& seen,
                            const std::vector<Eigen::Vector3f>& colours) {
  std::array<std::uint32_t, kNeighbours> index{};
  std::array<float, kNeighbours> distance2{};
  const std::size_t found = tree.knnSearch(point.data(), kNeighbours, index.data(), distance2.data());
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float total = 0.0F;
  for (std::size_t k = 0; k < found; ++k) {
    const float unlike = (seen.intensity[index[k]] - intensity) / kAlike;
    const float weight = (std::exp(-unlike * unlike) + kLeastAlike) / (distance2[k] + kBlur_m * kBlur_m);
    sum += weight * colours[index[k]];
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

  const PointSet known = points.subset(seen);
  std::vector<Eigen::Vector3f> colours;
  for (const std::uint32_t i : seen) colours.push_back(looks[i].colour);
  const CloudView cloud{known};
  PointTree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  tree.buildIndex();
  std::vector<std::uint32_t> kept;
  for (std::size_t k = 0; k < unseen.size(); ++k) {
    if (!std::isfinite(near[k].range_m)) continue;
    const std::uint32_t i = unseen[k];
    kept.push_back(i);
    out.looks.push_back(near[k]);
    out.looks.back().colour = colour_near(points.position.col(i), points.intensity[i], tree, known, colours);
  }
  out.points = points.subset(kept);
  return out;
}

}  // namespace simuli
