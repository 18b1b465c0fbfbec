#include "optim/initialize_actors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

namespace simuli {
namespace {

/// A wheel stands on the road, and so do points in the lowest part of a box: those stay with the background.
constexpr double kRoad_m = 0.1;
/// Kinds whose left and right are alike.
constexpr std::array<std::string_view, 4> kVehicles{"car", "van", "truck", "bus"};

/// Gives unseen points the look of the nearest seen one within two voxels of their mirror image.
void mirror_looks(const PointSet& points, double voxel_m, std::vector<PointLook>& looks) {
  const double cell_m = 2.0 * voxel_m;
  using Cell = std::array<int, 3>;
  const auto cell_of = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3i c = (p / cell_m).array().floor().cast<int>();
    return Cell{c.x(), c.y(), c.z()};
  };
  const auto position = [&](std::size_t i) -> Eigen::Vector3d {
    return points.position.col(static_cast<Eigen::Index>(i)).cast<double>();
  };
  std::map<Cell, std::vector<std::size_t>> seen;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (std::isfinite(looks[i].range_m)) seen[cell_of(position(i))].push_back(i);
  }
  const std::vector<PointLook> first = looks;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (std::isfinite(first[i].range_m)) continue;
    const Eigen::Vector3d image = position(i).cwiseProduct(Eigen::Vector3d(1.0, -1.0, 1.0));
    const Cell middle = cell_of(image);
    double nearest_m = cell_m;
    for (int k = 0; k < 27; ++k) {
      const auto cell = seen.find({middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1, middle[2] + k / 9 - 1});
      if (cell == seen.end()) continue;
      for (const std::size_t other : cell->second) {
        const double apart_m = (position(other) - image).norm();
        if (!(apart_m < nearest_m)) continue;
        nearest_m = apart_m;
        looks[i] = first[other];
      }
    }
  }
}

}  // namespace

std::vector<Actor> moving_actors(const std::vector<Actor>& all, double min_travel_m) {
  std::vector<Actor> out;
  for (const Actor& actor : all) {
    if (actor.travel_m() >= min_travel_m) out.push_back(actor);
  }
  return out;
}

ActorPoints::ActorPoints(std::vector<Actor> actors,
                         const ActorPointOptions& options,
                         const Eigen::Vector3d& scene_origin)
    : actors_(std::move(actors)), options_(options), scene_origin_(scene_origin) {
  grids_.assign(actors_.size(), VoxelGrid(options.voxel_m));
}

bool ActorPoints::mirrors(const Actor& actor) const {
  return options_.mirror && std::find(kVehicles.begin(), kVehicles.end(), actor.kind) != kVehicles.end();
}

void ActorPoints::start_sweep(double time_start_s, double time_end_s) {
  sweep_ = actors_during(actors_, time_start_s, time_end_s, scene_origin_);
}

bool ActorPoints::add(const Eigen::Vector3d& p_scene, double time_fraction, double intensity) {
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    const ActorView& view = sweep_[i];
    if (!view.is_there) continue;
    const Eigen::Vector3d half = 0.5 * actors_[i].size_m + Eigen::Vector3d::Constant(options_.margin_m);
    const Eigen::Vector3d about = (1.0 - time_fraction) * view.scene_from_actor_start.translation +
                                  time_fraction * view.scene_from_actor_end.translation;
    if ((p_scene - about).squaredNorm() > half.squaredNorm()) continue;
    const Pose scene_from_actor =
        interpolate(view.scene_from_actor_start, view.scene_from_actor_end, time_fraction);
    const Eigen::Vector3d p = scene_from_actor.inverse() * p_scene;
    const bool inside = std::abs(p.x()) <= half.x() && std::abs(p.y()) <= half.y() && p.z() <= half.z() &&
                        p.z() >= -0.5 * actors_[i].size_m.z() + kRoad_m;
    if (!inside) continue;
    grids_[i].add(p, intensity);
    if (mirrors(actors_[i])) grids_[i].add({p.x(), -p.y(), p.z()}, intensity);
    return true;
  }
  return false;
}

void ActorPoints::finish() {
  points_.clear();
  for (VoxelGrid& grid : grids_) points_.push_back(grid.averages());
}

std::size_t ActorPoints::count() const {
  std::size_t sum = 0;
  for (const PointSet& points : points_) sum += points.size();
  return sum;
}

PointSet ActorPoints::placed(const PointSet& background, double time_s) const {
  PointSet out = background;
  const std::vector<ActorView> views = actors_during(actors_, time_s, time_s, scene_origin_);
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    PointSet moved = points_[i];
    if (views[i].is_there) {
      const Pose& pose = views[i].scene_from_actor_start;
      const Eigen::Matrix3f rotation = pose.rotation.toRotationMatrix().cast<float>();
      moved.position = (rotation * moved.position).colwise() + pose.translation.cast<float>().eval();
    } else {
      moved.position.setConstant(std::numeric_limits<float>::quiet_NaN());
    }
    out.append(moved);
  }
  return out;
}

std::vector<std::vector<PointLook>> ActorPoints::split(const std::vector<PointLook>& looks,
                                                       std::size_t background_count) const {
  std::vector<std::vector<PointLook>> out;
  auto at = looks.begin() + static_cast<std::ptrdiff_t>(background_count);
  for (const PointSet& points : points_) {
    const auto end = at + static_cast<std::ptrdiff_t>(points.size());
    out.emplace_back(at, end);
    at = end;
    if (mirrors(actors_[out.size() - 1])) mirror_looks(points, options_.voxel_m, out.back());
  }
  return out;
}

}  // namespace simuli
