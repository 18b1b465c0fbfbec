#pragma once
// Things that move through a scene: a box and the poses it took. Particles of an actor live in its frame:
// origin in the middle of the box, x forward, y left, z up.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"

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

/// How an actor changes its shape as it moves, beside its pose: offsets of its points, in its frame.
/// Trilinear between the nodes of a grid that spans its box, beyond it as on its faces; in time a uniform
/// cubic B-spline. Before the first and after the last knot it goes back the way it came, so that a longer
/// track keeps moving.
struct Deformation {
  std::array<int, 3> nodes{0, 0, 0};  // along length, width, height, those on the faces included: 2 or more
  double start_s = 0.0;               // where the first knot is
  double interval_s = 0.0;            // from a knot to the next
  std::vector<double> offsets_m;      // [knots][height][width][length][3]; empty: the actor is rigid

  /// Weights of four knots, which add up to 1; the same knot may come twice.
  struct KnotShares {
    std::array<std::size_t, 4> knot{};
    std::array<double, 4> share{};
  };
  [[nodiscard]] bool empty() const { return offsets_m.empty(); }
  [[nodiscard]] std::size_t node_count() const;
  [[nodiscard]] std::size_t knots() const;
  /// Of a deformation that is not empty.
  [[nodiscard]] KnotShares shares(double time_s) const;
  /// [nodes][3] m at that time; empty: rigid.
  [[nodiscard]] std::vector<double> at(double time_s) const;
};

/// Most nodes along a side, and knots, of a deformation.
inline constexpr int kMostDeformationNodes = 32;
inline constexpr std::size_t kMostDeformationKnots = 100'000;

struct Actor {
  std::string name;                                  // one of its own in the scene
  std::string kind;                                  // "car", "pedestrian", ...: free text
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // length, width, height
  std::vector<KeyPose> track;                        // strictly increasing in time
  Deformation deformation = {};                      // of its shape; empty: it is rigid

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
/// poses, not finite or not strictly increasing in time; offsets that are no whole knots or not finite.
void validate(const Actor& actor, const std::string& where);

[[nodiscard]] bool has_actor(const std::vector<Actor>& actors, const std::string& name);

/// Index of the actor of that name; Error{kUsage} naming those there are.
[[nodiscard]] std::size_t find_actor(const std::vector<Actor>& actors, const std::string& name);

/// The offsets of a deformation's nodes over one frame, between start and end in proportion.
struct DeformationView {
  std::array<int, 3> nodes{0, 0, 0};
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();  // of the box that the grid spans
  std::vector<double> start_m, end_m;                // [height][width][length][3]; empty: rigid

  [[nodiscard]] bool empty() const { return start_m.empty(); }
  /// [nodes][3] m at that share of the frame.
  [[nodiscard]] std::vector<double> at(double share) const;
};

/// What a point of an actor at p (actor's frame, m) is moved by, with those offsets [nodes][3] of its nodes.
[[nodiscard]] Eigen::Vector3d deformation_at(const std::array<int, 3>& nodes,
                                             const Eigen::Vector3d& half_m,
                                             const std::vector<double>& offsets_m,
                                             const Eigen::Vector3d& p);

/// An actor's poses and shapes over one frame, relative to the scene origin.
struct ActorView {
  bool is_there = false;
  Pose scene_from_actor_start;
  Pose scene_from_actor_end;
  DeformationView deformation = {};
  double share = 1.0;  // of its particles' opacity, above 0 up to 1
};
[[nodiscard]] std::vector<ActorView> actors_during(const std::vector<Actor>& actors,
                                                   double time_start_s,
                                                   double time_end_s,
                                                   const Eigen::Vector3d& scene_origin);

}  // namespace simuli
