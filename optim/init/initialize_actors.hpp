#pragma once
// Initialisation of actors: returns inside a box become points of its actor in the actor's frame, and pictures
// observe them at their poses at the picture's time.
#include <cstdint>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "optim/init/initialize_views.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Returns the actors of `all` that get particles of their own: those that travel at least min_travel_m. A
/// static background represents parked objects better than noisy labels.
[[nodiscard]] std::vector<Actor> moving_actors(const std::vector<Actor>& all, double min_travel_m);

/// Half of the background's voxel: passing vehicles are observed from nearer than most of a street.
inline constexpr double kActorPointVoxel_m = 0.05;

struct ActorPointOptions {
  double voxel_m = kActorPointVoxel_m;
  double margin_m = 0.1;         // margin added to boxes for inexact labels
  bool register_tracks = false;  // corrects tracks by the returns (actor_tracks.hpp)
};

/// The points of all actors.
class ActorPoints {
 public:
  ActorPoints(std::vector<Actor> actors,
              const ActorPointOptions& options,
              const Eigen::Vector3d& scene_origin);

  /// A ball in the scene frame that contains all returns of an actor during an interval.
  struct ActorBall {
    std::size_t actor = 0;
    Eigen::Vector3d middle;
    double radius_m = 0.0;
  };
  /// Returns the balls of the actors present at any time from first_s to last_s, in order.
  [[nodiscard]] std::vector<ActorBall> places(double first_s, double last_s) const;
  /// Adds a return at time_s, within the interval of `places`, if it is in a box or below its lower edge;
  /// returns false for background.
  bool add(const Eigen::Vector3d& p_scene,
           double time_s,
           double intensity,
           const std::vector<ActorBall>& places);
  /// Finishes adding and computes the points of each actor in its frame. Points in a box near the ground, as
  /// determined from surrounding points, move to `background`, because wheels touch the road.
  void finish(VoxelGrid& background);
  /// Fills holes without returns (glass) in a picture's view of the actors by points at the range of the
  /// surrounding points, for the camera set only. `blocks`: of the background. Call finish_holes() after the
  /// last picture.
  void add_holes(const ImageView& view, double time_s, const PointSet& background, const PointBlocks& blocks);
  void finish_holes();

  /// With the offsets of register_tracks.
  [[nodiscard]] const std::vector<Actor>& actors() const { return actors_; }
  [[nodiscard]] const std::vector<PointSet>& points() const { return points_; }
  [[nodiscard]] const std::vector<PointSet>& camera_points() const { return camera_points_; }
  [[nodiscard]] std::size_t count() const;         // of points()
  [[nodiscard]] std::size_t camera_count() const;  // of camera_points()
  /// Returns `background` followed by all actors' camera points (those of actors[0] first) at their scene
  /// positions at time_s. Points of actors that are absent, or whose box the view sees from behind, are moved
  /// out of sight of all pictures.
  [[nodiscard]] PointSet placed(const PointSet& background, double time_s, const ImageView& view) const;
  /// Marks cells that see a box, which do not show background.
  void cover(const ImageView& view, double time_s, Coverage& coverage) const;
  /// Splits the observations after those of `background_count` points by actor.
  [[nodiscard]] std::vector<std::vector<PointObservation>> split(
      const std::vector<PointObservation>& observations, std::size_t background_count) const;

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
