#pragma once
// Edits of a trained scene: motion and presence of its actors. All sensors see the same edit, without training.
// Throws Error{kUsage} for unknown names and for names already in use.
#include <Eigen/Core>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "host/core/scene/scene.hpp"

namespace simuli {

/// A change of an actor's motion. Its particles do not change, so a single frame can be edited without copying
/// the scene.
struct ActorEdit {
  struct Remove {};                                  // absent from all frames
  struct Move {                                      // along its whole track, in its own frame
    Eigen::Vector3d by_m = Eigen::Vector3d::Zero();  // forward, left, up
  };
  struct Turn {            // along its whole track, about its own up axis
    double yaw_rad = 0.0;  // to its left
  };
  struct Retime {          // replays the track, from its start
    double rate = 1.0;     // speed factor, above 0
    double delay_s = 0.0;  // later than recorded
  };
  struct Retrack {
    std::vector<KeyPose> track;
  };
  using Change = std::variant<Remove, Move, Retime, Retrack, Turn>;

  std::string actor;
  Change change;
};

/// Returns `actors` after the edits, in order; a removed actor has an empty track. Throws Error{kUsage} for
/// unknown names and invalid numbers, Error{kInput} for a track that validate() rejects.
[[nodiscard]] std::vector<Actor> edited(std::vector<Actor> actors, const std::vector<ActorEdit>& edits);

/// Removes an actor and its particles.
void remove_actor(Scene& scene, const std::string& name);

/// Applies the edit permanently; a removal also removes the particles.
void edit_actor(Scene& scene, const ActorEdit& edit);

/// Applies ActorEdit::Move permanently.
void move_actor(Scene& scene, const std::string& name, const Eigen::Vector3d& by_m);

/// Applies ActorEdit::Turn permanently.
void turn_actor(Scene& scene, const std::string& name, double yaw_rad);

/// Scales an actor by `factor`: its box and its particles, about the middle of the box's base, so that it stays
/// on the ground. Throws Error{kUsage} for a factor that is not above 0 and finite, Error{kInput} for a box
/// that validate() rejects.
void resize_actor(Scene& scene, const std::string& name, double factor);

/// Applies ActorEdit::Retime permanently.
void retime_actor(Scene& scene, const std::string& name, double rate, double delay_s);

/// Applies ActorEdit::Retrack permanently.
void retrack_actor(Scene& scene, const std::string& name, std::vector<KeyPose> track);

/// Adds a second actor `copy_name` with the particles and the track of `name`. Throws Error{kInput} for an
/// invalid name (need_name()), Error{kUsage} for one in use.
void duplicate_actor(Scene& scene, const std::string& name, const std::string& copy_name);

/// Names of duplicated actors -> name of the recorded original.
using ActorCopies = std::map<std::string, std::string>;
/// Records that `copy_name` duplicates `name`, or the original of `name` if that is a copy itself.
void add_copy(ActorCopies& copies, const std::string& name, const std::string& copy_name);
/// Returns the recorded original of an actor, which is the actor itself unless it is a copy.
[[nodiscard]] const std::string& original_of(const ActorCopies& copies, const std::string& name);

/// Adds the actor `name` of another scene as `new_name`, with its particles of both sets. Its track is in the
/// other scene's world: set one of this world with retrack_actor(). SH bands that a set lacks are dropped,
/// missing ones are 0.
void add_actor(Scene& scene, const Scene& other, const std::string& name, const std::string& new_name);

/// Converts the static particles of `object` to the only actor of a scene, for add_actor(). Its box contains
/// all but the outermost particles of the camera set, or of the LiDAR set if that is empty. It stands on
/// world_from_base, the middle of its box's base, at all times. Throws Error{kInput} for an object without
/// particles.
[[nodiscard]] Scene as_actor(const Scene& object, const std::string& name, const Pose& world_from_base);

// A scene's particles as one set without actors, for formats without actors.

/// Returns the background without actors, including the inpainted sets.
[[nodiscard]] GaussianSet background_of(const Scene& scene, SetKind kind);

/// Returns the background, followed by the actors present at that time (seconds of the log) at their positions
/// then: m from Scene::origin.
[[nodiscard]] GaussianSet moment_of(const Scene& scene, SetKind kind, double time_s);

}  // namespace simuli
