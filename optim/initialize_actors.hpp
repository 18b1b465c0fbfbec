#pragma once
// The actors' share of the initialisation: returns inside a box become points of its actor, in the actor's
// frame, and pictures look at them where they were when the picture was taken.
#include <cstdint>
#include <vector>

#include "host/scene/actor.hpp"
#include "optim/initialize_points.hpp"
#include "optim/initialize_views.hpp"

namespace simuli {

/// The actors of `all` that get particles of their own: those that travel at least min_travel_m. What stands
/// still is modelled better without the noise of its labels.
[[nodiscard]] std::vector<Actor> moving_actors(const std::vector<Actor>& all, double min_travel_m);

struct ActorPointOptions {
  double voxel_m = 0.05;
  double margin_m = 0.1;  // labels are not exact: boxes reach this much farther, but for the road below
  bool mirror = false;    // vehicles look the same from left and right: adds each point's mirror image
};

/// The points of all actors.
class ActorPoints {
 public:
  ActorPoints(std::vector<Actor> actors,
              const ActorPointOptions& options,
              const Eigen::Vector3d& scene_origin);

  /// The actors' poses for the add() calls of one sweep.
  void start_sweep(double time_start_s, double time_end_s);
  /// Takes a return at that share of the sweep if it is in a box; false: it is of the background.
  bool add(const Eigen::Vector3d& p_scene, double time_fraction, double intensity);
  /// Ends adding: the points of each actor, in its frame.
  void finish();

  [[nodiscard]] const std::vector<Actor>& actors() const { return actors_; }
  [[nodiscard]] const std::vector<PointSet>& points() const { return points_; }
  [[nodiscard]] std::size_t count() const;
  /// `background` and behind it all actors' points (those of actors[0] first) as they stand in the scene at
  /// time_s. Where an actor is not there, its points are where no picture sees them.
  [[nodiscard]] PointSet placed(const PointSet& background, double time_s) const;
  /// Looks behind those of `background_count` points, parted by actor. With `mirror`, a point of a vehicle that
  /// no picture saw takes the look of the point nearest to its mirror image.
  [[nodiscard]] std::vector<std::vector<PointLook>> split(const std::vector<PointLook>& looks,
                                                          std::size_t background_count) const;

 private:
  [[nodiscard]] bool mirrors(const Actor& actor) const;

  std::vector<Actor> actors_;
  ActorPointOptions options_;
  Eigen::Vector3d scene_origin_;
  std::vector<VoxelGrid> grids_;
  std::vector<ActorView> sweep_;
  std::vector<PointSet> points_;
};

}  // namespace simuli
