#pragma once
// Surfaces of actors that are seen and send nothing back: black paint, glass. No return tells of them, but
// rays that drop do, together with those that other rays came through.
#include <cstdint>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "io/log/log.hpp"
#include "optim/init/dark_votes.hpp"
#include "optim/init/init_options.hpp"
#include "optim/init/posed_frames.hpp"
#include "optim/init/points/points.hpp"

namespace simuli {

/// What the rays of all sweeps say of the boxes of actors, each cut into voxels in the actor's frame.
class DarkSurfaces {
 public:
  /// `actors` as their tracks are known by then.
  DarkSurfaces(std::vector<Actor> actors, double voxel_m, const Eigen::Vector3d& scene_origin);

  /// The rays of a sweep that pass a box before they return, or don't. Rays in blind arcs say nothing.
  void add(const PosedSweep& posed, double time_start_s, double time_end_s);
  /// Of each actor, in its frame: where rays that dropped first meet a dark voxel (DarkVotes). One point per
  /// voxel, of intensity 0.
  [[nodiscard]] std::vector<PointSet> points() const;

 private:
  /// A ray in the actor's frame, from where it enters the box to where it leaves.
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
  /// Calls visit(voxel, place) for the voxels along a way, in order, until it returns false.
  template <class Visit>
  void walk(const Box& box, const Way& way, Visit&& visit) const;

  std::vector<Actor> actors_;
  double voxel_m_;
  Eigen::Vector3d scene_origin_;
  std::vector<Box> boxes_;
};

/// Such surfaces of what stands still (dark_still.hpp; scene frame), then of each actor of `scene` (its
/// frame): [1 + actors] sets of points, of intensity 0. `scene` has its LiDAR set. Error{kInput} when a sweep
/// can't be read.
[[nodiscard]] std::vector<PointSet> dark_points(const Log& log,
                                                const std::vector<const SweepFrame*>& sweeps,
                                                const InitOptions& options,
                                                const Scene& scene);

}  // namespace simuli
