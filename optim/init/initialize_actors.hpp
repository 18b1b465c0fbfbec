#pragma once
// The actors' share of the initialisation: returns inside a box become points of its actor, in the actor's
// frame, and pictures look at them where they were when the picture was taken.
#include <cstdint>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// The actors of `all` that get particles of their own: those that travel at least min_travel_m. What stands
/// still is modelled better without the noise of its labels.
[[nodiscard]] std::vector<Actor> moving_actors(const std::vector<Actor>& all, double min_travel_m);

/// Half the background's: what drives by is looked at from nearer than what a street ends with. Not measured.
inline constexpr double kActorPointVoxel_m = 0.05;

struct ActorPointOptions {
  double voxel_m = kActorPointVoxel_m;
  double margin_m = 0.1;         // labels are not exact: boxes reach this much farther
  bool register_tracks = false;  // lets the returns say where the actors were (actor_tracks.hpp)
};

/// The points of all actors.
class ActorPoints {
 public:
  ActorPoints(std::vector<Actor> actors,
              const ActorPointOptions& options,
              const Eigen::Vector3d& scene_origin);

  /// A ball, scene frame, outside of which no return of a while is an actor's.
  struct ActorBall {
    std::size_t actor = 0;
    Eigen::Vector3d middle;
    double radius_m = 0.0;
  };
  /// Of the actors that are there at any time from first_s to last_s, in their order.
  [[nodiscard]] std::vector<ActorBall> places(double first_s, double last_s) const;
  /// Takes a return at time_s, a time of the places', if it is in a box or below its lower rim; false: it is
  /// of the background.
  bool add(const Eigen::Vector3d& p_scene,
           double time_s,
           double intensity,
           const std::vector<ActorBall>& places);
  /// Ends adding: the points of each actor, in its frame. What a box takes near the ground, as the points
  /// around tell it, goes to `background` instead: a wheel stands on the road.
  void finish(VoxelGrid& background);
  /// Closes the holes that no laser fills (glass) in what a picture shows of the actors: points as far away
  /// as those around, for the camera set alone. `blocks`: of the background. finish_holes() after the last
  /// picture.
  void add_holes(const ImageView& view, double time_s, const PointSet& background, const PointBlocks& blocks);
  void finish_holes();

  /// With the offsets of register_tracks.
  [[nodiscard]] const std::vector<Actor>& actors() const { return actors_; }
  [[nodiscard]] const std::vector<PointSet>& points() const { return points_; }
  [[nodiscard]] const std::vector<PointSet>& camera_points() const { return camera_points_; }
  [[nodiscard]] std::size_t count() const;         // of points()
  [[nodiscard]] std::size_t camera_count() const;  // of camera_points()
  /// `background` and behind it all actors' camera points (those of actors[0] first) as they stand in the
  /// scene at time_s. What the view would show behind a box is where no picture sees it, and so are points of
  /// actors that are not there.
  [[nodiscard]] PointSet placed(const PointSet& background, double time_s, const ImageView& view) const;
  /// Marks the cells that look at a box: what they show is no background.
  void cover(const ImageView& view, double time_s, Coverage& coverage) const;
  /// Looks behind those of `background_count` points, parted by actor.
  [[nodiscard]] std::vector<std::vector<PointObservation>> split(const std::vector<PointObservation>& looks,
                                                          std::size_t background_count) const;

 private:
  struct Return {
    std::size_t actor = 0;
    double time_s = 0.0;
    Eigen::Vector3d p_scene;
    double intensity = 0.0;
  };
  [[nodiscard]] Pose scene_from_actor(std::size_t actor, double time_s) const;
  [[nodiscard]] Eigen::Vector3d half_m(std::size_t actor) const {
    return 0.5 * actors_[actor].size_m + Eigen::Vector3d::Constant(options_.margin_m);
  }

  std::vector<Actor> actors_;
  ActorPointOptions options_;
  Eigen::Vector3d scene_origin_;
  std::vector<Return> returns_;
  std::vector<VoxelGrid> holes_;
  std::vector<PointSet> points_, camera_points_;
};

}  // namespace simuli
