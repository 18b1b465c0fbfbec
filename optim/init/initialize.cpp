#include "optim/init/initialize.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/core/scene/ground/ground_map.hpp"
#include "io/splat/ply.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/dark_surfaces.hpp"
#include "optim/init/ground_near.hpp"
#include "optim/init/initialize_actors.hpp"
#include "optim/init/initialize_depth.hpp"
#include "optim/init/initialize_environment.hpp"
#include "optim/init/initialize_moving.hpp"
#include "optim/init/initialize_sets.hpp"
#include "optim/init/initialize_unseen.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/initialize_walls.hpp"
#include "optim/init/points/points.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/init/sky.hpp"
#include "optim/init/walls_upward.hpp"

namespace simuli {
namespace {

constexpr double kInfinitelyFar_m = 1e9;  // distance at which the drive does not change directions

/// Adds returns inside an actor's box to the actor, all others to the grid.
void add_points(
    const PosedSweep& posed, double time_start_s, double time_end_s, VoxelGrid& grid, ActorPoints& actors) {
  const Sweep& sweep = posed.sweep;
  const SightMaker sights(posed.lidar);
  if (sweep.range.empty()) return;
  const auto time_of = [&](float fraction) { return time_start_s + fraction * (time_end_s - time_start_s); };
  const auto [first, last] =
      std::minmax_element(sweep.rays.time_fraction.begin(), sweep.rays.time_fraction.end());
  const std::vector<ActorPoints::ActorBall> places = actors.places(time_of(*first), time_of(*last));
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] == 0.0F) continue;  // fired without return
    const double azimuth = sweep.rays.azimuth[i];
    const Pose scene_from_lidar =
        interpolate(posed.scene_from_lidar_start, posed.scene_from_lidar_end, sweep.rays.time_fraction[i]);
    const Eigen::Vector3d p_lidar =
        ray_origin(posed.lidar, sweep.rays, i) +
        static_cast<double>(sweep.range[i]) * Lidar::direction(azimuth, sweep.rays.elevation[i]);
    const Eigen::Vector3d p_scene = scene_from_lidar * p_lidar;
    if (!actors.add(p_scene, time_of(sweep.rays.time_fraction[i]), sweep.intensity[i], places)) {
      grid.add(
          p_scene, sweep.intensity[i], sights.of(sweep.rays, i, sweep.range[i], scene_from_lidar.rotation));
    }
  }
}

PointSet keep_static(const PointSet& points, const std::vector<bool>& moved) {
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (!moved[i]) kept.push_back(static_cast<std::uint32_t>(i));
  }
  return points.subset(kept);
}

/// Keeps the points at `indices` and their observations.
void keep(PointSet& points,
          std::vector<PointObservation>& observations,
          const std::vector<std::uint32_t>& indices) {
  std::vector<PointObservation> kept_observations;
  kept_observations.reserve(indices.size());
  for (const std::uint32_t i : indices) kept_observations.push_back(observations[i]);
  points = points.subset(indices);
  observations = std::move(kept_observations);
}

/// Drops points that no image saw. Returns their number.
std::size_t keep_seen(PointSet& points, std::vector<PointObservation>& observations) {
  std::vector<std::uint32_t> seen;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (std::isfinite(observations[i].range_m)) seen.push_back(static_cast<std::uint32_t>(i));
  }
  const std::size_t unseen = points.size() - seen.size();
  keep(points, observations, seen);
  return unseen;
}

/// Thins to `limit` points. Returns the number of dropped points.
std::size_t keep_some(PointSet& points,
                      std::vector<PointObservation>& observations,
                      std::size_t limit,
                      std::uint64_t seed) {
  const std::size_t count = points.size();
  keep(points, observations, thin(count, limit, seed));
  return count - points.size();
}

/// Adds the log's own points, one per voxel, for the camera set. Returns their number.
std::size_t add_log_points(const Log& log, const Eigen::Vector3d& origin, double voxel_m, PointSet& points) {
  VoxelGrid grid(voxel_m);
  for (const Eigen::Vector3d& p : read_points_ply(log.folder / log.points)) grid.add(p - origin, 0.0);
  points.append(grid.averages());
  return grid.points();
}

double farthest_m(const PointSet& points, const Trajectory& trajectory, const Eigen::Vector3d& origin) {
  double farthest = points.size() > 0 ? std::sqrt(points.position.colwise().squaredNorm().maxCoeff()) : 0.0;
  for (const TimedPose& p : trajectory.poses()) {
    farthest = std::max(farthest, (p.pose.translation - origin).norm());
  }
  return farthest;
}

/// Angular spacing in degrees of the far shell's particles, seen from the scene's origin: some pixels of a
/// camera.
constexpr double kShellSpacing_deg = 0.5;
/// Smallest share of a direction's pictures that must see an object beyond the LiDARs' reach for a shell
/// particle.
constexpr double kShellOpenShare = 0.5;

/// Pictures that must show sky at a point to remove it; one may be wrong.
constexpr int kLeastAgainst = 2;

/// State of one initialisation.
class Initialisation {
 public:
  Initialisation(const Log& log,
                 const FrameSelection& frames,
                 const InitOptions& options,
                 const std::function<void(std::size_t, std::size_t)>& progress)
      : log_(log),
        frames_(frames),
        options_(options),
        progress_(progress),
        sweeps_(training_frames(log.sweeps, HeldOutRule(log, frames))),
        images_(training_frames(log.images, HeldOutRule(log, frames))) {
    if (sweeps_.empty() && images_.empty()) {
      throw_input_error(log.folder.string(), "training frames", "0", "at least one image or sweep");
    }
    scene_.name = log.name;
    scene_.origin = scene_origin(log.world_from_rig);
    if (options.actors) scene_.actors = moving_actors(log.actors, options.actor_min_travel_m);
    actors_.emplace(scene_.actors,
                    ActorPointOptions{kActorPointVoxel_m, options.actor_margin_m, options.register_tracks},
                    scene_.origin);
  }

  [[nodiscard]] SceneInit run() && {
    tell();
    read_returns();
    if (options_.drop_moving) drop_moving();
    place_lidar_set();
    out_.unmet = walls_upward(log_, sweeps_, scene_.origin, points_, options_, [this] { step(); });
    report_.unmet_points = static_cast<std::size_t>(out_.unmet.size());
    place_dark_surfaces();
    add_ground();
    add_points_of_pictures();
    take_colours();
    place_camera_set();
    return std::move(out_);
  }

 private:
  void read_returns();
  void drop_moving();
  void place_lidar_set();
  void place_dark_surfaces();
  void add_ground();
  void add_points_of_pictures();
  [[nodiscard]] SkyMasks find_sky() const;
  void drop_before_sky(const SkyMasks& sky);
  void take_colours();
  std::size_t keep_seen_ground();
  void place_camera_set();

  /// Counts a file as read.
  void step() {
    ++files_;
    tell();
  }
  void tell() {
    if (!progress_) return;
    progress_(files_,
              (1 + (options_.drop_moving ? 1 : 0) + (options_.lidar_walls_m > 0.0 ? 1 : 0)) * sweeps_.size() +
                  (1 + (options_.sweep_depth ? 1 : 0) + (options_.walls ? 1 : 0)) * images_.size());
  }

  const Log& log_;
  const FrameSelection& frames_;
  const InitOptions& options_;
  const std::function<void(std::size_t, std::size_t)>& progress_;
  std::vector<const SweepFrame*> sweeps_;
  std::vector<const ImageFrame*> images_;
  std::size_t files_ = 0;
  SceneInit out_;
  Scene& scene_ = out_.scene;
  InitReport& report_ = out_.report;
  std::optional<ActorPoints> actors_;
  PointSet points_;                             // background, one per voxel
  std::vector<PointObservation> observations_;  // at points_, followed by the actors' points
  std::vector<ImageView> views_;                // [images_]
  std::optional<FarShell> shell_, sky_;
  std::size_t ground_begin_ = 0, ground_end_ = 0;  // ground points that no LiDAR reached, range in points_
};

/// Averages returns to one point per voxel; returns inside actors' boxes become points of the actors.
void Initialisation::read_returns() {
  VoxelGrid grid(options_.voxel_m);
  expect(log_, sweeps_);
  for (const SweepFrame* frame : sweeps_) {
    add_points(
        load_sweep(log_, *frame, scene_.origin), frame->time_start_s, frame->time_end_s, grid, *actors_);
    step();
  }
  actors_->finish(grid);
  scene_.actors = actors_->actors();
  points_ = grid.averages();
  report_.sweeps = sweeps_.size();
  report_.points = grid.points();
  report_.actor_points = actors_->count();
  report_.voxels = points_.size();
}

void Initialisation::drop_moving() {
  std::vector<PointVotes> votes(points_.size());
  const PointBlocks blocks(points_);
  for (const SweepFrame* frame : sweeps_) {
    const PosedSweep s = load_sweep(log_, *frame, scene_.origin);
    // A ray list has no known neighbours, which the motion test needs.
    if (const auto* const lidar = std::get_if<Lidar>(&s.lidar)) {
      vote_on_points(
          s.sweep, *lidar, s.scene_from_lidar_start, s.scene_from_lidar_end, points_, votes, &blocks);
    }
    step();
  }
  std::vector<bool> moved(points_.size());
  std::transform(votes.begin(), votes.end(), moved.begin(), is_moving);
  points_ = keep_static(points_, moved);
  report_.moving_points = report_.voxels - points_.size();
}

void Initialisation::place_lidar_set() {
  CellOptions cells_of = kLidarCells;
  cells_of.voxel_m = options_.voxel_m;
  const std::vector<SurfaceCell> cells = surface_cells(points_, cells_of);
  std::vector<SurfaceCell> kept;
  for (const std::uint32_t i : thin(cells.size(), options_.max_lidar, frames_.seed)) kept.push_back(cells[i]);
  scene_.lidar = lidar_set(points_, kept, options_.voxel_m, options_);
  cells_of.voxel_m = kActorPointVoxel_m;
  for (std::size_t i = 0; i < scene_.actors.size(); ++i) {
    const PointSet& points = actors_->points()[i];
    append(scene_.lidar,
           lidar_set(points, surface_cells(points, cells_of), kActorPointVoxel_m, options_),
           static_cast<std::uint32_t>(i + 1));
  }
  report_.lidar_cells = cells.size();
  report_.lidar_particles = static_cast<std::size_t>(scene_.lidar.size());
  report_.lidar_thinned = cells.size() - kept.size();
}

/// Adds surfaces without returns, which pictures show.
void Initialisation::place_dark_surfaces() {
  const std::vector<PointSet> dark = dark_points(log_, sweeps_, options_, scene_);
  for (std::size_t owner = 0; owner < dark.size(); ++owner) {
    if (dark[owner].size() == 0) continue;
    append(scene_.lidar, dark_set(dark[owner], options_), static_cast<std::uint32_t>(owner));
    report_.dark_points += dark[owner].size();
  }
  report_.lidar_particles += report_.dark_points;
  points_.append(dark[0]);
}

/// Adds ground around the rig that no LiDAR reached to the camera set.
void Initialisation::add_ground() {
  ground_begin_ = ground_end_ = points_.size();
  if (scene_.lidar.size() == 0) return;
  std::vector<Pose> path;
  for (const ImageFrame* frame : images_) {
    path.push_back(log_.world_from_rig.at(middle_s(*frame)));
    path.back().translation -= scene_.origin;
  }
  points_.append(ground_near(ground_of(scene_), path, points_, options_.voxel_m));
  ground_end_ = points_.size();
}

/// Adds points for the camera set only: the log's own points, points in LiDAR holes, and points with depth from
/// pictures only.
void Initialisation::add_points_of_pictures() {
  if (!log_.points.empty()) report_.points += add_log_points(log_, scene_.origin, options_.voxel_m, points_);
  const PointBlocks blocks(points_);
  for (const ImageFrame* frame : images_) {
    const ImageView view = image_view(log_, *frame, scene_.origin, frames_.image_scale);
    actors_->add_holes(view, middle_s(*frame), points_, blocks);
  }
  actors_->finish_holes();
  const SkyMasks sky = find_sky();
  if (options_.sweep_depth) {
    const PictureDepths depths{
        log_, images_, scene_.origin, frames_.image_scale, options_.voxel_m, *actors_, sky};
    report_.depth_points = depths.add_to(points_, [this] { step(); });
  }
  // After multi-view depth, which is more accurate where it exists.
  if (options_.walls) {
    const WallsAbove walls{log_, images_, scene_.origin, frames_.image_scale, options_.voxel_m, *actors_};
    report_.wall_points = walls.add_to(points_, [this] { step(); });
  }
  drop_before_sky(sky);
}

SkyMasks Initialisation::find_sky() const {
  SkyMasks out;
  SkyFinder finder(log_, sweeps_, scene_.origin);
  expect(log_, images_, frames_.image_scale);
  for (const ImageFrame* frame : images_) {
    const auto [image, view] = load_view(log_, *frame, scene_.origin, frames_.image_scale);
    out[frame] = finder.find(*frame, image, view);
  }
  return out;
}

/// Removes points beyond the LiDARs' reach where pictures show sky (docs/DECISIONS.md, "Sky and environment").
void Initialisation::drop_before_sky(const SkyMasks& sky) {
  std::vector<int> against(points_.size());
  for (const auto& [frame, mask] : sky) {
    if (mask.empty()) continue;
    const ImageView view = image_view(log_, *frame, scene_.origin, frames_.image_scale);
    for (std::size_t i = ground_end_; i < points_.size(); ++i) {
      Eigen::Vector2d pixel;
      double range_m = 0.0;
      const Eigen::Vector3d p = points_.position.col(static_cast<Eigen::Index>(i)).cast<double>();
      if (view.project(p, pixel, range_m) && mask.at(pixel)) ++against[i];
    }
  }
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (against[i] < kLeastAgainst) kept.push_back(static_cast<std::uint32_t>(i));
  }
  points_ = points_.subset(kept);
}

/// Collects the pictures' colours of all points and directions.
void Initialisation::take_colours() {
  const double extent_m = farthest_m(points_, log_.world_from_rig, scene_.origin);
  shell_.emplace(kShellSpacing_deg,
                 options_.shell_distance_m > 0.0 ? options_.shell_distance_m : shell_distance_m(extent_m));
  const bool has_environment = options_.environment_width > 0;
  sky_.emplace(has_environment ? 360.0 / options_.environment_width : kShellSpacing_deg, kInfinitelyFar_m);
  observations_.resize(points_.size() + actors_->camera_count());
  const PointBlocks blocks(points_);
  expect(log_, images_, frames_.image_scale);
  for (const ImageFrame* frame : images_) {
    const auto [image, view] = load_view(log_, *frame, scene_.origin, frames_.image_scale);
    views_.push_back(view);
    // Two samples per shell cell and axis, so that no cell between samples stays empty.
    const double finest_rad = std::min(shell_->spacing_rad(), sky_->spacing_rad());
    const double sample_px = 0.5 * finest_rad / view.pixel_size_at_1m();
    const int cell_px = std::max(1, static_cast<int>(sample_px));
    const std::vector<std::uint32_t> near = blocks.seen_from(view);
    const PointSet placed = actors_->placed(points_.subset(near), middle_s(*frame), view);
    std::vector<PointObservation> own;
    for (const std::uint32_t i : near) own.push_back(observations_[i]);
    own.insert(
        own.end(), observations_.begin() + static_cast<std::ptrdiff_t>(points_.size()), observations_.end());
    Coverage coverage = look_at_points(view, image, placed, options_.voxel_m, cell_px, own);
    for (std::size_t i = 0; i < near.size(); ++i) observations_[near[i]] = own[i];
    std::copy(own.begin() + static_cast<std::ptrdiff_t>(near.size()),
              own.end(),
              observations_.begin() + static_cast<std::ptrdiff_t>(points_.size()));
    actors_->cover(view, middle_s(*frame), coverage);
    const std::vector<FarObservation> observations = far_observations(view, image, coverage);
    if (options_.max_shell > 0) shell_->add(observations);
    if (has_environment) sky_->add(observations);
    step();
  }
  report_.images = images_.size();
}

/// Keeps, of the ground that no LiDAR reached, only points that pictures show. Returns their number.
std::size_t Initialisation::keep_seen_ground() {
  std::vector<std::uint32_t> kept;
  std::size_t ground = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const bool is_ground = i >= ground_begin_ && i < ground_end_;
    if (is_ground && !std::isfinite(observations_[i].range_m)) continue;
    ground += is_ground ? 1 : 0;
    kept.push_back(static_cast<std::uint32_t>(i));
  }
  keep(points_, observations_, kept);
  return ground;
}

void Initialisation::place_camera_set() {
  auto actor_observations = actors_->split(observations_, points_.size());
  observations_.resize(points_.size());
  report_.ground_points = keep_seen_ground();
  const UnseenSurfaces unseen = unseen_surfaces(points_, observations_, views_, options_);
  report_.unseen_points = keep_seen(points_, observations_) - unseen.points;
  report_.joined_points = join_by_footprint(points_, observations_, options_.voxel_m, kCameraVoxel_px);
  report_.camera_thinned = keep_some(points_, observations_, options_.max_camera, frames_.seed);
  report_.joined_points += unseen.points - unseen.cells.size();
  const auto unseen_kept = thin(unseen.cells.size(), options_.max_camera - points_.size(), frames_.seed);
  report_.camera_thinned += unseen.cells.size() - unseen_kept.size();

  const std::vector<FarShell::Patch> patches = shell_->patches(kShellOpenShare);
  const auto shell_kept = thin(patches.size(), options_.max_shell, frames_.seed);
  scene_.camera = camera_set(points_, observations_, options_);
  append(scene_.camera, unseen_set(unseen, unseen_kept, options_), 0);
  append(scene_.camera, shell_set(*shell_, patches, shell_kept, options_), 0);
  for (std::size_t i = 0; i < scene_.actors.size(); ++i) {
    PointSet seen = actors_->camera_points()[i];
    static_cast<void>(keep_seen(seen, actor_observations[i]));
    static_cast<void>(keep_some(seen, actor_observations[i], options_.max_camera, frames_.seed));
    append(
        scene_.camera, camera_set(seen, actor_observations[i], options_), static_cast<std::uint32_t>(i + 1));
  }
  if (!patches.empty()) scene_.camera_background = sky_colour(patches);
  if (options_.environment_width > 0) {
    scene_.environment = environment_of(sky_->patches(kShellOpenShare), options_.environment_width);
  }
  report_.shell_particles = shell_kept.size();
  report_.filled_particles = unseen_kept.size();
  report_.camera_particles = static_cast<std::size_t>(scene_.camera.size());
  report_.shell_distance_m = shell_->distance_m();
}

}  // namespace

double shell_distance_m(double farthest_m) {
  constexpr double kExtents = 3.0, kNearest_m = 200.0;
  return std::max(kNearest_m, kExtents * farthest_m);
}

InitReport& InitReport::operator+=(const InitReport& other) {
  sweeps += other.sweeps;
  images += other.images;
  points += other.points;
  voxels += other.voxels;
  actor_points += other.actor_points;
  dark_points += other.dark_points;
  moving_points += other.moving_points;
  unseen_points += other.unseen_points;
  joined_points += other.joined_points;
  depth_points += other.depth_points;
  wall_points += other.wall_points;
  ground_points += other.ground_points;
  unmet_points += other.unmet_points;
  lidar_cells += other.lidar_cells;
  lidar_thinned += other.lidar_thinned;
  camera_thinned += other.camera_thinned;
  lidar_particles += other.lidar_particles;
  camera_particles += other.camera_particles;
  filled_particles += other.filled_particles;
  shell_particles += other.shell_particles;
  shell_distance_m = std::max(shell_distance_m, other.shell_distance_m);
  seconds += other.seconds;
  return *this;
}

SceneInit initialize_scene(const Log& log,
                           const FrameSelection& frames,
                           const InitOptions& options,
                           const std::function<void(std::size_t, std::size_t)>& progress) {
  check_fields(frames);
  check_fields(options);
  const auto begin = std::chrono::steady_clock::now();
  SceneInit out = Initialisation(log, frames, options, progress).run();
  out.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace simuli
