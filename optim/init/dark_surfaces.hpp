#pragma once
// Surfaces of actors that return nothing: black paint, glass. They are detected by dropped rays together with
// rays that passed.
#include <cstdint>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/init/dark_votes.hpp"
#include "optim/init/init_options.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// Votes of all sweeps' rays in the boxes of actors, in voxels of the actor's frame.
class DarkSurfaces {
 public:
  /// `actors` with their tracks as refined so far.
  DarkSurfaces(std::vector<Actor> actors, double voxel_m, const Eigen::Vector3d& scene_origin);

  /// Adds the rays of a sweep that intersect a box before they return, or drop. Ignores rays in blind arcs.
  void add(const PosedSweep& posed, double time_start_s, double time_end_s);
  /// Returns for each actor, in its frame, the first dark voxels (DarkVotes) along dropped rays: one point per
  /// voxel, with intensity 0.
  [[nodiscard]] std::vector<PointSet> points() const;

 private:
  /// Segment of a ray inside the box, in the actor's frame.
  struct Way {
    Eigen::Vector3f from, to;
  };
  struct Box {
    Eigen::Vector3d half;   // m
    Eigen::Array3i voxels;  // along each axis
    std::vector<DarkVotes> votes;
    std::vector<Way> dropped;
  };

  void add_ray(std::size_t actor,
               const Pose& scene_from_actor,
               const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction,
               double range_m);
  [[nodiscard]] std::size_t voxel_of(const Box& box, const Eigen::Vector3d& p) const;
  /// Calls visit(voxel, place) for the voxels along a segment, in order, until it returns false.
  template <class Visit>
  void walk(const Box& box, const Way& way, Visit&& visit) const;

  std::vector<Actor> actors_;
  double voxel_m_;
  Eigen::Vector3d scene_origin_;
  std::vector<Box> boxes_;
};

/// Returns dark points of static surfaces (dark_still.hpp; scene frame) and of each actor of `scene` (actor
/// frame): [1 + actors] point sets with intensity 0. `scene` has its LiDAR set. Throws Error{kInput} when a
/// sweep cannot be read.
[[nodiscard]] std::vector<PointSet> dark_points(const Log& log,
                                                const std::vector<const SweepFrame*>& sweeps,
                                                const InitOptions& options,
                                                const Scene& scene);

}  // namespace simuli
