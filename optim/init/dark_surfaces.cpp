#include "optim/init/dark_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/core/base/parallel.hpp"
#include "host/core/scene/ground/ground_map.hpp"
#include "host/device/render/scene/actor_boxes.hpp"
#include "io/log/frame_files.hpp"
#include "optim/init/dark_still.hpp"

namespace simuli {
namespace {

/// Space in front of a return is free, except for errors of the track and the thickness of the surface.
constexpr double kOffSurface_m = 0.2;
/// Sides of voxels for actors and for static surfaces (docs/DECISIONS.md, "LiDAR set").
constexpr double kActorVoxel_m = 0.1, kStillVoxel_m = 0.15;

Pose scene_from_actor(const Actor& actor, double time_s, const Eigen::Vector3d& scene_origin) {
  Pose pose = actor.at(time_s);
  pose.translation -= scene_origin;
  return pose;
}

}  // namespace

DarkSurfaces::DarkSurfaces(std::vector<Actor> actors, double voxel_m, const Eigen::Vector3d& scene_origin)
    : actors_(std::move(actors)), voxel_m_(voxel_m), scene_origin_(scene_origin) {
  for (const Actor& actor : actors_) {
    Box box{0.5 * actor.size_m, {}, {}, {}};
    box.voxels = (actor.size_m.array() / voxel_m).ceil().max(1.0).cast<int>();
    box.votes.resize(static_cast<std::size_t>(box.voxels.cast<std::int64_t>().prod()));
    boxes_.push_back(std::move(box));
  }
}

std::size_t DarkSurfaces::voxel_of(const Box& box, const Eigen::Vector3d& p) const {
  const Eigen::Array3i at =
      ((p + box.half).array() / voxel_m_).floor().cast<int>().max(0).min(box.voxels - 1);
  return (static_cast<std::size_t>(at.z()) * static_cast<std::size_t>(box.voxels.y()) +
          static_cast<std::size_t>(at.y())) *
             static_cast<std::size_t>(box.voxels.x()) +
         static_cast<std::size_t>(at.x());
}

template <class Visit>
void DarkSurfaces::walk(const Box& box, const Way& way, Visit&& visit) const {
  const Eigen::Vector3d from = way.from.cast<double>(), along = (way.to - way.from).cast<double>();
  // Steps of half a voxel: may miss grazed voxels, and none counts twice.
  const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * along.norm() / voxel_m_)));
  std::size_t last = std::numeric_limits<std::size_t>::max();
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector3d p = from + (i + 0.5) / steps * along;
    const std::size_t voxel = voxel_of(box, p);
    if (voxel == last) continue;
    last = voxel;
    if (!visit(voxel, p)) return;
  }
}

void DarkSurfaces::add_ray(std::size_t actor,
                           const Pose& scene_from_actor,
                           const Eigen::Vector3d& origin,
                           const Eigen::Vector3d& direction,
                           double range_m) {
  Box& box = boxes_[actor];
  const Pose actor_from_scene = scene_from_actor.inverse();
  const Eigen::Vector3d o = actor_from_scene * origin, d = actor_from_scene.rotation * direction;
  const bool returns = range_m > 0.0;
  const BoxInterval in = inside_box(o, d, box.half);
  const double first = std::max(in.first, 0.0);
  double last = in.last;
  if (returns) last = std::min(last, range_m - kOffSurface_m);
  if (!(first < last) || !std::isfinite(last)) return;
  const Way way{(o + first * d).cast<float>(), (o + last * d).cast<float>()};
  walk(box, way, [&](std::size_t voxel, const Eigen::Vector3d&) {
    ++(returns ? box.votes[voxel].through : box.votes[voxel].dropped);
    return true;
  });
  if (!returns) box.dropped.push_back(way);
}

void DarkSurfaces::add(const PosedSweep& posed, double time_start_s, double time_end_s) {
  const Sweep& sweep = posed.sweep;
  const double duration_s = time_end_s - time_start_s;
  std::vector<SceneRay> rays(sweep.range.size());
  parallel_each(rays.size(), [&](std::size_t i) { rays[i] = ray_in_scene(posed, i); });
  const auto add_to = [&](std::size_t a) {
    if (!actors_[a].is_there(time_start_s) && !actors_[a].is_there(time_end_s)) return;
    const Pose start = scene_from_actor(actors_[a], time_start_s, scene_origin_),
               end = scene_from_actor(actors_[a], time_end_s, scene_origin_);
    const Eigen::Vector3d middle = 0.5 * (start.translation + end.translation);
    const double reach_m = boxes_[a].half.norm() + 0.5 * (end.translation - start.translation).norm();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto& [origin, direction] = rays[i];
      const Eigen::Vector3d to = middle - origin;
      if (direction.dot(to) < -reach_m || direction.cross(to).squaredNorm() > reach_m * reach_m) continue;
      const double time_s = time_start_s + sweep.rays.time_fraction[i] * duration_s;
      if (!actors_[a].is_there(time_s) || is_blind(posed.lidar, sweep.rays, i)) continue;
      add_ray(a, scene_from_actor(actors_[a], time_s, scene_origin_), origin, direction, sweep.range[i]);
    }
  };
  parallel_each(
      actors_.size(), [&](std::size_t a) { add_to(a); }, 1);
}

std::vector<PointSet> DarkSurfaces::points() const {
  std::vector<PointSet> out;
  for (const Box& box : boxes_) {
    VoxelGrid grid(voxel_m_);
    for (const Way& way : box.dropped) {
      walk(box, way, [&](std::size_t voxel, const Eigen::Vector3d& place) {
        if (!box.votes[voxel].is_dark()) return true;
        grid.add(place, 0.0);
        return false;
      });
    }
    out.push_back(grid.averages());
  }
  return out;
}

/// Boxes of the actors present during a sweep.
static std::vector<MovingBox> boxes_during(const Scene& scene, const SweepFrame& frame) {
  constexpr double kWider_m = 0.2;  // margin on each side for errors of tracks
  std::vector<MovingBox> out;
  for (const Actor& actor : scene.actors) {
    if (!actor.is_there(frame.time_start_s) && !actor.is_there(frame.time_end_s)) continue;
    out.push_back({(0.5 * actor.size_m).array() + kWider_m,
                   scene_from_actor(actor, frame.time_start_s, scene.origin),
                   scene_from_actor(actor, frame.time_end_s, scene.origin)});
  }
  return out;
}

/// Returns dark points of static surfaces.
static PointSet still_points(const Log& log,
                             const std::vector<const SweepFrame*>& sweeps,
                             const Scene& scene) {
  const GroundMap ground = ground_of(scene);
  DarkStill dark(ground, kStillVoxel_m);
  expect(log, sweeps);
  for (const SweepFrame* frame : sweeps) {
    dark.add_dropped(load_sweep(log, *frame, scene.origin), boxes_during(scene, *frame));
  }
  expect(log, sweeps);
  for (const SweepFrame* frame : sweeps) dark.add_returned(load_sweep(log, *frame, scene.origin));
  return dark.points();
}

std::vector<PointSet> dark_points(const Log& log,
                                  const std::vector<const SweepFrame*>& sweeps,
                                  const InitOptions& options,
                                  const Scene& scene) {
  std::vector<PointSet> out(1 + scene.actors.size());
  if (!options.dark_surfaces) return out;
  if (scene.lidar.size() > 0) out[0] = still_points(log, sweeps, scene);
  if (scene.actors.empty()) return out;
  DarkSurfaces dark(scene.actors, kActorVoxel_m, scene.origin);
  expect(log, sweeps);
  for (const SweepFrame* frame : sweeps) {
    dark.add(load_sweep(log, *frame, scene.origin), frame->time_start_s, frame->time_end_s);
  }
  std::vector<PointSet> of_actors = dark.points();
  std::move(of_actors.begin(), of_actors.end(), out.begin() + 1);
  return out;
}

}  // namespace simuli
