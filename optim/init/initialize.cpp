#include "optim/init/initialize.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/fields.hpp"
#include "io/picture/image.hpp"
#include "io/splat/ply.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/init/initialize_depth.hpp"
#include "optim/init/initialize_environment.hpp"
#include "optim/init/initialize_moving.hpp"
#include "optim/init/initialize_points.hpp"
#include "optim/init/initialize_sets.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {
namespace {

constexpr double kShellExtents = 3.0;      // the shell stands at three times the farthest point ...
constexpr double kShellNearest_m = 200.0;  // ... but never nearer than this
constexpr double kInfinitelyFar_m = 1e9;   // a drive moves no direction there

/// Mean sensor position in whole metres: offsets from it are small and exact in float.
Eigen::Vector3d scene_origin(const Trajectory& world_from_rig) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TimedPose& p : world_from_rig.poses()) sum += p.pose.translation;
  return (sum / static_cast<double>(world_from_rig.poses().size())).array().round();
}

Pose shifted(Pose world_from_sensor, const Eigen::Vector3d& origin) {
  world_from_sensor.translation -= origin;
  return world_from_sensor;
}

/// A sweep with the poses at its start and end.
struct PosedSweep {
  const LidarModel& lidar;
  Sweep sweep;
  Pose scene_from_lidar_start;
  Pose scene_from_lidar_end;
};

PosedSweep load_sweep(const Log& log, const SweepFrame& frame, const Eigen::Vector3d& origin) {
  const LogLidar& lidar = log.lidar(frame.lidar);
  return {lidar.model,
          read_sweep(log.folder / frame.file, lidar.model),
          shifted(log.world_from_rig.at(frame.time_start_s) * lidar.rig_from_lidar, origin),
          shifted(log.world_from_rig.at(frame.time_end_s) * lidar.rig_from_lidar, origin)};
}

/// Returns in an actor's box go to the actor, all others to the grid.
void add_points(
    const PosedSweep& posed, double time_start_s, double time_end_s, VoxelGrid& grid, ActorPoints& actors) {
  const Sweep& sweep = posed.sweep;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] == 0.0F) continue;  // fired, nothing came back
    const double azimuth = sweep.rays.azimuth[i];
    const Pose scene_from_lidar =
        interpolate(posed.scene_from_lidar_start, posed.scene_from_lidar_end, sweep.rays.time_fraction[i]);
    const Eigen::Vector3d p_lidar =
        ray_origin(posed.lidar, sweep.rays, i) +
        static_cast<double>(sweep.range[i]) * Lidar::direction(azimuth, sweep.rays.elevation[i]);
    const Eigen::Vector3d p_scene = scene_from_lidar * p_lidar;
    const double time_s = time_start_s + sweep.rays.time_fraction[i] * (time_end_s - time_start_s);
    if (!actors.add(p_scene, time_s, sweep.intensity[i])) {
      grid.add(p_scene, sweep.intensity[i]);
    }
  }
}

ImageView image_view(const Log& log,
                     const ImageFrame& frame,
                     const Eigen::Vector3d& origin,
                     double image_scale) {
  const LogCamera& camera = log.camera(frame.camera);
  return {scaled_camera(camera.model, image_scale),
          shifted(log.world_from_rig.at(frame.time_start_s) * camera.rig_from_camera, origin),
          shifted(log.world_from_rig.at(frame.time_end_s) * camera.rig_from_camera, origin)};
}

/// The picture of `frame` and the view it was taken from, both at the training size.
std::pair<Image, ImageView> load_view(const Log& log,
                                      const ImageFrame& frame,
                                      const Eigen::Vector3d& origin,
                                      double image_scale) {
  ImageView view = image_view(log, frame, origin, image_scale);
  return {load_image(log, frame, view.camera()), std::move(view)};
}

double middle_s(const ImageFrame& frame) { return 0.5 * (frame.time_start_s + frame.time_end_s); }

PointSet keep_static(const PointSet& points, const std::vector<bool>& moved) {
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (!moved[i]) kept.push_back(static_cast<std::uint32_t>(i));
  }
  return points.subset(kept);
}

/// Drops points that no image saw, then thins to `limit`. Returns the number of unseen points.
std::size_t keep_seen(PointSet& points,
                      std::vector<PointLook>& looks,
                      std::size_t limit,
                      std::uint64_t seed) {
  std::vector<std::uint32_t> seen;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (std::isfinite(looks[i].range_m)) seen.push_back(static_cast<std::uint32_t>(i));
  }
  const std::size_t unseen = points.size() - seen.size();
  std::vector<std::uint32_t> kept;
  std::vector<PointLook> kept_looks;
  for (const std::uint32_t k : thin(seen.size(), limit, seed)) {
    kept.push_back(seen[k]);
    kept_looks.push_back(looks[seen[k]]);
  }
  points = points.subset(kept);
  looks = std::move(kept_looks);
  return unseen;
}

/// Adds to `points` what the pictures of each camera show where no point is, one per voxel of twice the
/// side. `step` is called after each picture.
std::size_t add_picture_depths(const Log& log,
                               const std::vector<const ImageFrame*>& images,
                               const Eigen::Vector3d& origin,
                               const InitOptions& options,
                               const ActorPoints& actors,
                               const std::function<void()>& step,
                               PointSet& points) {
  constexpr std::size_t kReach = 2;  // pictures before and after
  struct Loaded {
    SweepPicture picture;
    Coverage coverage;
  };
  VoxelGrid grid(2.0 * options.voxel_m);
  for (const LogCamera& camera : log.cameras) {
    std::vector<const ImageFrame*> frames;
    for (const ImageFrame* frame : images) {
      if (frame->camera == camera.model.name) frames.push_back(frame);
    }
    std::deque<Loaded> window;  // frames [first, next)
    std::size_t first = 0, next = 0;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      for (; next < frames.size() && next <= k + kReach; ++next) {
        const auto [image, view] = load_view(log, *frames[next], origin, options.image_scale);
        const PointSet placed = actors.placed(points, middle_s(*frames[next]), view.origin());
        std::vector<PointLook> unused(placed.size());
        Coverage coverage =
            look_at_points(view, image, placed, options.voxel_m, options.sweep_cell_px, unused);
        actors.cover(view, middle_s(*frames[next]), coverage);
        window.push_back({sweep_picture(view, image), std::move(coverage)});
      }
      for (; first + kReach < k; ++first) window.pop_front();
      std::vector<const SweepPicture*> others;
      for (std::size_t i = 0; i < window.size(); ++i) {
        if (first + i != k) others.push_back(&window[i].picture);
      }
      const Loaded& here = window[k - first];
      for (const Eigen::Vector3d& p : sweep_depths(here.picture, others, here.coverage)) grid.add(p, 0.0);
      step();
    }
  }
  const PointSet found = grid.averages();
  points.append(found);
  return found.size();
}

/// Adds the log's own points, one per voxel, for the camera set. Returns how many there were.
std::size_t add_log_points(const Log& log, const Eigen::Vector3d& origin, double voxel_m, PointSet& points) {
  VoxelGrid grid(voxel_m);
  for (const Eigen::Vector3d& p : read_points_ply(log.folder / log.points)) grid.add(p - origin, 0.0);
  points.append(grid.averages());
  return grid.points();
}

template <class Frame>
std::vector<const Frame*> training_frames(const std::vector<Frame>& frames, int every) {
  std::vector<const Frame*> out;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!is_held_out(i, every)) out.push_back(&frames[i]);
  }
  return out;
}

double farthest_m(const PointSet& points, const Trajectory& trajectory, const Eigen::Vector3d& origin) {
  double farthest = points.size() > 0 ? std::sqrt(points.position.colwise().squaredNorm().maxCoeff()) : 0.0;
  for (const TimedPose& p : trajectory.poses()) {
    farthest = std::max(farthest, (p.pose.translation - origin).norm());
  }
  return farthest;
}

}  // namespace

void check(const InitOptions& o) {
  check_fields(o);
  const auto need = [](bool holds, const char* key, double found, const std::string& allowed) {
    if (!holds) throw Error(ErrorKind::kUsage, fmt::format("{}: found {}, allowed {}", key, found, allowed));
  };
  need(o.max_scale_m >= o.min_scale_m,
       "init.max_scale_m",
       o.max_scale_m,
       fmt::format("init.min_scale_m ({}) or more", o.min_scale_m));
  need(o.held_out_every >= 0 && o.held_out_every != 1, "held_out_every", o.held_out_every, "0, or 2 or more");
  need(o.image_scale > 0.0 && o.image_scale <= 1.0, "image_scale", o.image_scale, "above 0, at most 1");
}

SceneInit initialize_scene(const Log& log,
                           const InitOptions& options,
                           const std::function<void(std::size_t, std::size_t)>& progress) {
  check(options);
  const auto begin = std::chrono::steady_clock::now();
  const auto sweeps = training_frames(log.sweeps, options.held_out_every);
  const auto images = training_frames(log.images, options.held_out_every);
  if (sweeps.empty() && images.empty()) {
    throw_input_error(log.folder.string(), "training frames", "0", "at least one image or sweep");
  }
  std::size_t files = 0;
  const auto step = [&] {
    ++files;
    if (progress)
      progress(files,
               (options.drop_moving ? 2 : 1) * sweeps.size() + (options.sweep_depth ? 2 : 1) * images.size());
  };
  SceneInit out;
  InitReport& report = out.report;
  Scene& scene = out.scene;
  scene.name = log.name;
  scene.origin = scene_origin(log.world_from_rig);

  if (options.actors) scene.actors = moving_actors(log.actors, options.actor_min_travel_m);
  ActorPoints actors(
      scene.actors,
      {options.actor_voxel_m, options.actor_margin_m, options.mirror_actors, options.register_tracks},
      scene.origin);
  VoxelGrid grid(options.voxel_m);
  for (const SweepFrame* frame : sweeps) {
    add_points(load_sweep(log, *frame, scene.origin), frame->time_start_s, frame->time_end_s, grid, actors);
    step();
  }
  actors.finish(grid);
  scene.actors = actors.actors();
  PointSet points = grid.averages();
  report.sweeps = sweeps.size();
  report.points = grid.points();
  report.actor_points = actors.count();
  report.voxels = points.size();
  if (options.drop_moving) {
    std::vector<PointVotes> votes(points.size());
    for (const SweepFrame* frame : sweeps) {
      const PosedSweep s = load_sweep(log, *frame, scene.origin);
      // A list has no neighbouring rays to look through: it has no word on what moved.
      if (const auto* const lidar = std::get_if<Lidar>(&s.lidar)) {
        vote_on_points(s.sweep, *lidar, s.scene_from_lidar_start, s.scene_from_lidar_end, points, votes);
      }
      step();
    }
    std::vector<bool> moved(points.size());
    std::transform(votes.begin(), votes.end(), moved.begin(), is_moving);
    out.moving = MovingSpace(options.voxel_m, points, moved);
    points = keep_static(points, moved);
    report.moving_points = report.voxels - points.size();
  }

  const auto lidar_kept = thin(points.size(), options.max_lidar, options.seed);
  scene.lidar = lidar_set(points.subset(lidar_kept), options);
  for (std::size_t i = 0; i < scene.actors.size(); ++i) {
    append(scene.lidar, lidar_set(actors.points()[i], options), static_cast<std::uint32_t>(i + 1));
  }
  report.lidar_particles = static_cast<std::size_t>(scene.lidar.size());
  report.lidar_thinned = points.size() - lidar_kept.size();

  if (!log.points.empty()) report.points += add_log_points(log, scene.origin, options.voxel_m, points);
  for (const ImageFrame* frame : images) {
    const ImageView view = image_view(log, *frame, scene.origin, options.image_scale);
    actors.add_holes(view, middle_s(*frame), points);
  }
  actors.finish_holes();
  const std::size_t static_points = points.size();
  if (options.sweep_depth) {
    report.depth_points = add_picture_depths(log, images, scene.origin, options, actors, step, points);
  }
  const double extent_m = farthest_m(points, log.world_from_rig, scene.origin);
  FarShell shell(options.shell_spacing_deg, std::max(kShellNearest_m, kShellExtents * extent_m));
  const bool has_environment = options.environment_width > 0;
  FarShell sky(has_environment ? 360.0 / options.environment_width : options.shell_spacing_deg,
               kInfinitelyFar_m);
  std::vector<PointLook> looks(points.size() + actors.camera_count());
  for (const ImageFrame* frame : images) {
    const auto [image, view] = load_view(log, *frame, scene.origin, options.image_scale);
    // Two samples per shell cell and axis, so that no cell between two samples stays empty.
    const double finest_rad = std::min(shell.spacing_rad(), sky.spacing_rad());
    const double sample_px = 0.5 * finest_rad / view.pixel_size_at_1m();
    const int cell_px = std::max(1, static_cast<int>(sample_px));
    const PointSet placed = actors.placed(points, middle_s(*frame), view.origin());
    Coverage coverage = look_at_points(view, image, placed, options.voxel_m, cell_px, looks);
    actors.cover(view, middle_s(*frame), coverage);
    if (options.max_shell > 0) shell.add(view, image, coverage);
    if (has_environment) sky.add(view, image, coverage);
    step();
  }
  report.images = images.size();
  auto actor_looks = actors.split(looks, points.size());
  looks.resize(points.size());
  report.unseen_points = keep_seen(points, looks, options.max_camera, options.seed);
  report.camera_thinned = static_points + report.depth_points - report.unseen_points - points.size();

  const std::vector<FarShell::Patch> patches = shell.patches();
  const auto shell_kept = thin(patches.size(), options.max_shell, options.seed);
  scene.camera = camera_set(points, looks, options);
  append(scene.camera, shell_set(shell, patches, shell_kept, options), 0);
  for (std::size_t i = 0; i < scene.actors.size(); ++i) {
    PointSet seen = actors.camera_points()[i];
    (void)keep_seen(seen, actor_looks[i], options.max_camera, options.seed);
    append(scene.camera, camera_set(seen, actor_looks[i], options), static_cast<std::uint32_t>(i + 1));
  }
  if (!patches.empty()) {
    // What the set lets through is the sky, as far as is known: the mean of the upper half of the shell.
    std::vector<float> heights;
    for (const FarShell::Patch& patch : patches) heights.push_back(patch.direction.z());
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::nth_element(heights.begin(), middle, heights.end());
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float count = 0.0F;
    for (const FarShell::Patch& patch : patches) {
      if (patch.direction.z() < *middle) continue;
      sum += patch.colour;
      count += 1.0F;
    }
    for (std::size_t c = 0; c < 3; ++c)
      scene.camera_background[c] = sum[static_cast<Eigen::Index>(c)] / count;
  }
  if (has_environment) scene.environment = environment_of(sky.patches(), options.environment_width);
  report.shell_particles = shell_kept.size();
  report.camera_particles = static_cast<std::size_t>(scene.camera.size());
  report.shell_distance_m = shell.distance_m();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace simuli
