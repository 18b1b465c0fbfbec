#pragma once
// Moving objects of a scene: a box and its poses over time. Particles of an actor are in its frame: origin in
// the middle of the box, x forward, y left, z up.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/core/base/pose.hpp"

namespace simuli {

/// Pose of an actor at one time, and its correction by training.
struct KeyPose {
  double time_s = 0.0;  // seconds since the start of the log
  Pose world_from_actor;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();   // added to the position, world axes
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  // rotation vector about the actor's origin, world axes

  [[nodiscard]] Pose corrected() const;
};

/// Interpolation of a pose: keys [key] and [key + 1] with weights 1 - share and share. For a single key, or a
/// time outside of the track: share 0 of that key.
struct KeyShare {
  std::size_t key = 0;
  double share = 0.0;
};

/// Deformation of an actor in addition to its pose: offsets of its points in its frame. Trilinear between the
/// nodes of a grid that spans its box, constant beyond its faces; a uniform cubic B-spline in time. Before the
/// first and after the last knot it runs backwards, so that a longer track keeps moving.
struct Deformation {
  std::array<int, 3> nodes{0, 0, 0};  // along length, width, height, including those on the faces: 2 or more
  double start_s = 0.0;  // of the first knot
  double interval_s = 0.0;  // between knots
  std::vector<double> offsets_m;  // [knots][height][width][length][3]; empty: rigid

  /// Weights of four knots, which sum to 1; a knot may occur twice.
  struct KnotShares {
    std::array<std::size_t, 4> knot{};
    std::array<double, 4> share{};
  };
  [[nodiscard]] bool empty() const { return offsets_m.empty(); }
  [[nodiscard]] std::size_t node_count() const;
  [[nodiscard]] std::size_t knots() const;
  /// For a non-empty deformation.
  [[nodiscard]] KnotShares shares(double time_s) const;
  /// Returns [nodes][3] m at that time; empty: rigid.
  [[nodiscard]] std::vector<double> at(double time_s) const;
};

/// Largest numbers of nodes along a side, and of knots.
inline constexpr int kMostDeformationNodes = 32;
inline constexpr std::size_t kMostDeformationKnots = 100'000;

struct Actor {
  std::string name;  // unique in the scene
  std::string kind;                                  // "car", "pedestrian", ...: free text
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // length, width, height
  std::vector<KeyPose> track;                        // strictly increasing in time
  Deformation deformation = {};  // empty: rigid

  /// Whether the track covers this time; a key pose is valid for kReach_s before the first and after the last.
  [[nodiscard]] bool is_there(double time_s) const;
  /// world_from_actor: slerp of the corrected rotations, lerp of the corrected positions; end segments are
  /// extrapolated. Initialisation, training and rendering use this function.
  [[nodiscard]] Pose at(double time_s) const;
  /// Interpolation weights of at(), for its gradient.
  [[nodiscard]] KeyShare key_share(double time_s) const;
  /// Largest distance of the actor's origin from its first position, m.
  [[nodiscard]] double travel_m() const;

  /// A 10 Hz label is valid for its frame: half a period, doubled for sensors exposed at other times.
  static constexpr double kReach_s = 0.1;
};

/// Throws Error{kInput} with `where` and field: no name, a size that is not positive, a track without poses,
/// not finite or not strictly increasing in time; offsets of incomplete knots or not finite.
void validate(const Actor& actor, const std::string& where);

[[nodiscard]] bool has_actor(const std::vector<Actor>& actors, const std::string& name);

/// Returns the index of the actor of that name; throws Error{kUsage} with the known names.
[[nodiscard]] std::size_t find_actor(const std::vector<Actor>& actors, const std::string& name);

/// Offsets of a deformation's nodes during one frame, linear between start and end.
struct DeformationView {
  std::array<int, 3> nodes{0, 0, 0};
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();  // of the box that the grid spans
  std::vector<double> start_m, end_m;                // [height][width][length][3]; empty: rigid

  [[nodiscard]] bool empty() const { return start_m.empty(); }
  /// Returns [nodes][3] m at that share of the frame.
  [[nodiscard]] std::vector<double> at(double share) const;
};

/// Returns the offset of a point p of an actor (actor frame, m) for the offsets [nodes][3] of its nodes.
[[nodiscard]] Eigen::Vector3d deformation_at(const std::array<int, 3>& nodes,
                                             const Eigen::Vector3d& half_m,
                                             const std::vector<double>& offsets_m,
                                             const Eigen::Vector3d& p);

/// Poses and deformation of an actor during one frame, relative to the scene origin.
struct ActorView {
  bool is_there = false;
  Pose scene_from_actor_start;
  Pose scene_from_actor_end;
  DeformationView deformation = {};
  double share = 1.0;  // factor of its particles' opacity, in (0, 1]
};
[[nodiscard]] std::vector<ActorView> actors_during(const std::vector<Actor>& actors,
                                                   double time_start_s,
                                                   double time_end_s,
                                                   const Eigen::Vector3d& scene_origin);

}  // namespace simuli
