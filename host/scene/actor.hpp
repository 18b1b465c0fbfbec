#pragma once
// Things that move through a scene: a box and the poses it took. Particles of an actor live in its frame:
// origin in the middle of the box, x forward, y left, z up.
#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "host/scene/pose.hpp"

namespace simuli {

/// Where an actor was at one time, and how far training moved it from there.
struct KeyPose {
  double time_s = 0.0;  // seconds since the start of the log
  Pose world_from_actor;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();   // added to the position, world axes
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  // rotation vector about the actor's origin, world axes

  [[nodiscard]] Pose corrected() const;
};

/// What a pose at some time is made of: keys [key] and [key + 1] with weights 1 - share and share. One key
/// alone, or a time outside of the track: share 0 of that key.
struct KeyShare {
  std::size_t key = 0;
  double share = 0.0;
};

struct Actor {
  std::string name;                                  // one of its own in the scene
  std::string kind;                                  // "car", "pedestrian", ...: free text
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // length, width, height
  std::vector<KeyPose> track;                        // strictly increasing in time

  /// Whether the track tells of this time: a key pose stands for kReach_s before the first and after the
  /// last.
  [[nodiscard]] bool is_there(double time_s) const;
  /// world_from_actor: slerp of the corrected rotations, lerp of the corrected positions; the end segments
  /// are continued outside of the track. The one pose function of initialisation, training and rendering.
  [[nodiscard]] Pose at(double time_s) const;
  /// What at() is made of, for its gradient.
  [[nodiscard]] KeyShare key_share(double time_s) const;
  /// Farthest that the actor's origin gets from where it first was, m.
  [[nodiscard]] double travel_m() const;

  /// A label at 10 Hz stands for its frame: half a period, and as much again for sensors that are not exposed
  /// at its very time.
  static constexpr double kReach_s = 0.1;
};

/// Throws Error{kInput} naming `where` and field: no name, a size that is not positive, a track without
/// poses, not finite or not strictly increasing in time.
void validate(const Actor& actor, const std::string& where);

[[nodiscard]] bool has_actor(const std::vector<Actor>& actors, const std::string& name);

/// Index of the actor of that name; Error{kUsage} naming those there are.
[[nodiscard]] std::size_t find_actor(const std::vector<Actor>& actors, const std::string& name);

/// An actor's poses over one frame, relative to the scene origin.
struct ActorView {
  bool is_there = false;
  Pose scene_from_actor_start;
  Pose scene_from_actor_end;
};
[[nodiscard]] std::vector<ActorView> actors_during(const std::vector<Actor>& actors,
                                                   double time_start_s,
                                                   double time_end_s,
                                                   const Eigen::Vector3d& scene_origin);

}  // namespace simuli
