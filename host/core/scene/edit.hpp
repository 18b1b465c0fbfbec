#pragma once
// Edits of a trained scene: what its actors do, and which there are. All sensors see the same edit; nothing
// is trained again. Error{kUsage} for names that the scene does not have, or already has.
#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "host/core/scene/scene.hpp"

namespace simuli {

/// One change of what an actor does. Its particles stay as they are, so that a single frame can be edited
/// without a scene of its own.
struct ActorEdit {
  struct Remove {};                                  // it is nowhere
  struct Move {                                      // throughout its track, in its own frame
    Eigen::Vector3d by_m = Eigen::Vector3d::Zero();  // forward, left, up
  };
  struct Turn {            // throughout its track, about its own up
    double yaw_rad = 0.0;  // to its left
  };
  struct Retime {          // the track again, from where it begins
    double rate = 1.0;     // times as fast, above 0
    double delay_s = 0.0;  // later than recorded
  };
  struct Retrack {
    std::vector<KeyPose> track;
  };
  using Change = std::variant<Remove, Move, Retime, Retrack, Turn>;

  std::string actor;
  Change change;
};

/// `actors` after the edits, in their order: one that is removed has no track left. Error{kUsage} for a
/// name that there is not and numbers that are not allowed, Error{kInput} for a track that validate()
/// refuses.
[[nodiscard]] std::vector<Actor> edited(std::vector<Actor> actors, const std::vector<ActorEdit>& edits);

/// Takes an actor and its particles away.
void remove_actor(Scene& scene, const std::string& name);

/// The edit for good: a removal takes the particles, too.
void edit_actor(Scene& scene, const ActorEdit& edit);

/// ActorEdit::Move for good.
void move_actor(Scene& scene, const std::string& name, const Eigen::Vector3d& by_m);

/// ActorEdit::Turn for good.
void turn_actor(Scene& scene, const std::string& name, double yaw_rad);

/// Makes an actor `factor` times as large: its box and its particles, about the middle of the box's base, so
/// that it stands where it stood. Error{kUsage} for a factor that is not above 0 and finite, Error{kInput} for
/// a box that validate() refuses.
void resize_actor(Scene& scene, const std::string& name, double factor);

/// ActorEdit::Retime for good.
void retime_actor(Scene& scene, const std::string& name, double rate, double delay_s);

/// ActorEdit::Retrack for good.
void retrack_actor(Scene& scene, const std::string& name, std::vector<KeyPose> track);

/// Adds a second actor `copy_name` with the particles and the track of `name`. Error{kInput} for what is no name
/// (need_name()), Error{kUsage} for one that is taken.
void duplicate_actor(Scene& scene, const std::string& name, const std::string& copy_name);

/// Adds the actor `name` of another scene as `new_name`, with its particles of both sets. Its track is in the
/// other scene's world: give it one of this world with retrack_actor(). SH bands that a set does not have are
/// dropped, missing ones are 0.
void add_actor(Scene& scene, const Scene& other, const std::string& name, const std::string& new_name);

/// What stands still in `object` as the only actor of a scene, for add_actor(). Its box holds all but the
/// outermost of its particles, of the camera set, or of the LiDAR set where that is empty. It stands on world_from_base, the
/// middle of its box's base, at all times. Error{kInput} for an object without particles.
[[nodiscard]] Scene as_actor(const Scene& object, const std::string& name, const Pose& world_from_base);

}  // namespace simuli
