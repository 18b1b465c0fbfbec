#include "optim/init/initialize_actors.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "host/core/base/parallel.hpp"
#include "optim/base/evaluate_actors.hpp"
#include "optim/init/actor_tracks.hpp"

namespace simuli {
namespace {

/// Where the ground is unknown, the lowest part of a box counts as road.
constexpr double kRoad_m = 0.1;
constexpr double kGround_m = 0.05;   // height tolerance of ground points ...
constexpr double kLow_m = 0.3;       // ... in this lowest part of a box
constexpr double kHoleVoxels = 2.0;  // voxel side of hole points relative to the actor's points

/// Ground height from background points.
class Ground {
 public:
  explicit Ground(const PointSet& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3f p = points.position.col(static_cast<Eigen::Index>(i));
      heights_m_[cell_of(p.cast<double>())].push_back(p.z());
    }
  }
  /// Lower quartile of points within kReach_m of height `near_m` in the cells around p; no value with too few
  /// points.
  [[nodiscard]] std::optional<double> height_m(const Eigen::Vector3d& p, double near_m) const {
    std::vector<float> found;
    const Cell middle = cell_of(p);
    for (int k = 0; k < 9; ++k) {
      const auto cell = heights_m_.find({middle[0] + k % 3 - 1, middle[1] + k / 3 - 1});
      if (cell == heights_m_.end()) continue;
      for (const float z : cell->second) {
        if (std::abs(static_cast<double>(z) - near_m) < kReach_m) found.push_back(z);
      }
    }
    if (found.size() < kLeast) return std::nullopt;
    const auto quartile = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 4);
    std::nth_element(found.begin(), quartile, found.end());
    return *quartile;
  }

 private:
  using Cell = std::array<int, 2>;
  static constexpr double kCell_m = 0.5;
  static constexpr double kReach_m = 0.4;
  static constexpr std::size_t kLeast = 4;
  static Cell cell_of(const Eigen::Vector3d& p) {
    return {static_cast<int>(std::floor(p.x() / kCell_m)), static_cast<int>(std::floor(p.y() / kCell_m))};
  }
  std::map<Cell, std::vector<float>> heights_m_;
};

/// Conservative test whether objects in a ball can occlude a point from an eye, with few operations.
class BallBefore {
 public:
  BallBefore(const Eigen::Vector3d& centre, double radius_m, const Eigen::Vector3d& eye)
      : eye_(eye.cast<float>()),
        centre_((centre - eye).cast<float>()),
        centre2_(centre_.squaredNorm()),
        radius_(static_cast<float>(radius_m) + kSlack_m + kSlack * centre_.norm() + kSlack * eye_.norm()) {}
  [[nodiscard]] bool may_hide(const Eigen::Vector3f& point) const {
    const Eigen::Vector3f way = point - eye_;
    const float along = way.dot(centre_), way2 = way.squaredNorm();
    // Distance of the ball's centre to the segment, whose nearest point is an end or in between.
    if (along <= 0.0F) return !(centre2_ > radius_ * radius_);
    if (along >= way2) return !((way - centre_).squaredNorm() > radius_ * radius_);
    return !((centre2_ - radius_ * radius_) * way2 > along * along * (1.0F + kSlack));
  }

 private:
  static constexpr float kSlack_m = 0.05F, kSlack = 1e-4F;  // far above float rounding
  Eigen::Vector3f eye_, centre_;
  float centre2_, radius_;
};

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
  holes_.assign(actors_.size(), VoxelGrid(kHoleVoxels * options.voxel_m));
}

Pose ActorPoints::scene_from_actor(std::size_t actor, double time_s) const {
  Pose pose = actors_[actor].at(time_s);
  pose.translation -= scene_origin_;
  return pose;
}

std::vector<ActorPoints::ActorBall> ActorPoints::places(double first_s, double last_s) const {
  constexpr double kSlack_m = 1e-3;  // far above double rounding
  std::vector<ActorBall> out;
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    const std::vector<KeyPose>& track = actors_[i].track;
    if (track.empty()) continue;
    const double from_s = std::max(first_s, track.front().time_s - Actor::kReach_s);
    const double to_s = std::min(last_s, track.back().time_s + Actor::kReach_s);
    if (from_s > to_s) continue;
    // Positions are linear between key poses.
    Eigen::AlignedBox3d way;
    way.extend(scene_from_actor(i, from_s).translation).extend(scene_from_actor(i, to_s).translation);
    for (const KeyPose& key : track) {
      if (key.time_s > from_s && key.time_s < to_s) way.extend(scene_from_actor(i, key.time_s).translation);
    }
    out.push_back({i, way.center(), half_m(i).norm() + 0.5 * way.diagonal().norm() + kSlack_m});
  }
  return out;
}

bool ActorPoints::add(const Eigen::Vector3d& p_scene,
                      double time_s,
                      double intensity,
                      const std::vector<ActorBall>& places) {
  for (const auto& [i, middle, radius_m] : places) {
    if ((p_scene - middle).squaredNorm() > radius_m * radius_m || !actors_[i].is_there(time_s)) continue;
    const Eigen::Vector3d half = half_m(i);
    const Pose pose = scene_from_actor(i, time_s);
    if ((p_scene - pose.translation).squaredNorm() > half.squaredNorm()) continue;
    const Eigen::Vector3d p = pose.inverse() * p_scene;
    if (!(p.array().abs() <= half.array()).all()) continue;
    returns_.push_back({i, time_s, p_scene, intensity});
    return true;
  }
  return false;
}

void ActorPoints::finish(VoxelGrid& background) {
  const Ground ground(background.averages());
  const auto is_road = [&](const Return& r) {
    const double bottom_m = -0.5 * actors_[r.actor].size_m.z();
    const Pose pose = scene_from_actor(r.actor, r.time_s);
    const double above_bottom_m = (pose.inverse() * r.p_scene).z() - bottom_m;
    if (!(above_bottom_m < kLow_m)) return false;
    const double foot_m = (pose * Eigen::Vector3d(0.0, 0.0, bottom_m)).z();
    const std::optional<double> ground_m = ground.height_m(r.p_scene, foot_m);
    return ground_m ? r.p_scene.z() - *ground_m < kGround_m : above_bottom_m < kRoad_m;
  };
  std::vector<std::uint8_t> of_road(returns_.size());
  parallel_each(
      returns_.size(), [&](std::size_t i) { of_road[i] = is_road(returns_[i]) ? 1 : 0; }, 1024);
  std::vector<Return> kept;
  std::vector<std::vector<ActorReturn>> by_actor(actors_.size());
  for (std::size_t i = 0; i < returns_.size(); ++i) {
    const Return& r = returns_[i];
    if (of_road[i] != 0) {
      background.add(r.p_scene, r.intensity);
      continue;
    }
    kept.push_back(r);
    by_actor[r.actor].push_back({r.time_s, r.p_scene + scene_origin_});
  }
  returns_.clear();
  if (options_.register_tracks) {
    for (std::size_t i = 0; i < actors_.size(); ++i) register_track(actors_[i], by_actor[i]);
  }
  std::vector<VoxelGrid> grids(actors_.size(), VoxelGrid(options_.voxel_m));
  for (const Return& r : kept) {
    const Eigen::Vector3d half = half_m(r.actor);
    const Eigen::Vector3d p =
        (scene_from_actor(r.actor, r.time_s).inverse() * r.p_scene).cwiseMin(half).cwiseMax(-half);
    grids[r.actor].add(p, r.intensity);
  }
  points_.clear();
  for (VoxelGrid& grid : grids) points_.push_back(grid.averages());
  camera_points_ = points_;
}

std::size_t ActorPoints::count() const {
  std::size_t sum = 0;
  for (const PointSet& points : points_) sum += points.size();
  return sum;
}

std::size_t ActorPoints::camera_count() const {
  std::size_t sum = 0;
  for (const PointSet& points : camera_points_) sum += points.size();
  return sum;
}

PointSet ActorPoints::placed(const PointSet& background, double time_s, const ImageView& view) const {
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  struct Before {
    BallBefore ball;
    Pose actor_from_scene;
    Eigen::Vector3d half, from;  // from: the eye, in the actor's frame
  };
  std::vector<Before> all_before;
  const ViewCone cone(view);
  const Eigen::Vector3d eye = view.origin();
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    if (!actors_[i].is_there(time_s)) continue;
    const Eigen::Vector3d half = half_m(i);
    const Pose scene_from_actor_then = scene_from_actor(i, time_s);
    // The ray to a visible point stays in the view cone.
    if (!cone.may_meet(scene_from_actor_then.translation, half.norm())) continue;
    const Pose actor_from_scene = scene_from_actor_then.inverse();
    all_before.push_back({BallBefore(scene_from_actor_then.translation, half.norm(), eye),
                          actor_from_scene,
                          half,
                          actor_from_scene * eye});
  }
  const auto hides = [](const Before& before, const Eigen::Vector3f& point) {
    if (!before.ball.may_hide(point)) return false;
    const Eigen::Vector3d way = before.actor_from_scene * point.cast<double>() - before.from;
    const BoxInterval in = inside_box(before.from, way, before.half);
    return in.first > 0.0 && in.first < in.last && in.last < 1.0;
  };
  PointSet out = background;
  parallel_each(background.size(), [&](std::size_t i) {
    const auto k = static_cast<Eigen::Index>(i);
    const Eigen::Vector3f point = background.position.col(k);
    const bool hidden = std::any_of(
        all_before.begin(), all_before.end(), [&](const Before& before) { return hides(before, point); });
    if (hidden) out.position.col(k).setConstant(kNowhere);
  });
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    PointSet moved = camera_points_[i];
    if (actors_[i].is_there(time_s)) {
      const Pose pose = scene_from_actor(i, time_s);
      const Eigen::Matrix3f rotation = pose.rotation.toRotationMatrix().cast<float>();
      moved.position = (rotation * moved.position).colwise() + pose.translation.cast<float>().eval();
    } else {
      moved.position.setConstant(kNowhere);
    }
    out.append(moved);
  }
  return out;
}

void ActorPoints::cover(const ImageView& view, double time_s, Coverage& coverage) const {
  struct Box {
    Pose actor_from_scene;
    Eigen::Vector3d half, centre;  // the centre in the scene frame
  };
  std::vector<Box> boxes;
  const ViewCone cone(view);
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    if (!actors_[i].is_there(time_s)) continue;
    const Eigen::Vector3d half = half_m(i);
    const Pose pose = scene_from_actor(i, time_s);
    if (cone.may_meet(pose.translation, half.norm()))
      boxes.push_back({pose.inverse(), half, pose.translation});
  }
  if (boxes.empty()) return;
  const auto meets = [](const Box& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const Eigen::Vector3d way = box.centre - origin;  // the direction is a unit vector
    if (way.cross(direction).squaredNorm() > 1.001 * box.half.squaredNorm()) return false;
    const BoxInterval in =
        inside_box(box.actor_from_scene * origin, box.actor_from_scene.rotation * direction, box.half);
    return std::max(in.first, 0.0) <= in.last;
  };
  const auto columns = static_cast<std::size_t>(coverage.columns);
  constexpr std::size_t kCellsPerThread = 1024;
  parallel_each(
      coverage.covered.size(),
      [&](std::size_t i) {
        const Eigen::Vector2d at(static_cast<double>(i % columns), static_cast<double>(i / columns));
        Eigen::Vector3d origin, direction;
        view.unproject((at.array() + 0.5) * static_cast<double>(coverage.cell_px), origin, direction);
        if (direction.isZero(0.0)) return;
        const bool is_met = std::any_of(
            boxes.begin(), boxes.end(), [&](const Box& box) { return meets(box, origin, direction); });
        if (is_met) coverage.covered[i] = 1;
      },
      kCellsPerThread);
}

std::vector<std::vector<PointObservation>> ActorPoints::split(
    const std::vector<PointObservation>& observations, std::size_t background_count) const {
  std::vector<std::vector<PointObservation>> out;
  auto at = observations.begin() + static_cast<std::ptrdiff_t>(background_count);
  for (const PointSet& points : camera_points_) {
    const auto end = at + static_cast<std::ptrdiff_t>(points.size());
    out.emplace_back(at, end);
    at = end;
  }
  return out;
}

}  // namespace simuli
