#pragma once
// Edits of a trained scene: what its actors do, and which there are. All sensors see the same edit; nothing
// is trained again. Error{kUsage} for names that the scene does not have, or already has.
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace simuli {

/// Takes an actor and its particles away.
void remove_actor(Scene& scene, const std::string& name);

/// Moves an actor by (forward, left, up) metres in its own frame, throughout its track.
void move_actor(Scene& scene, const std::string& name, const Eigen::Vector3d& by_m);

/// Replays the track `rate` times as fast (above 0), starting delay_s later than recorded.
void retime_actor(Scene& scene, const std::string& name, double rate, double delay_s);

/// Sends an actor along other poses.
void retrack_actor(Scene& scene, const std::string& name, std::vector<KeyPose> track);

/// Adds a second actor `copy_name` with the particles and the track of `name`.
void duplicate_actor(Scene& scene, const std::string& name, const std::string& copy_name);

/// Adds the actor `name` of another scene as `new_name`, with its particles of both sets. Its track is in the
/// other scene's world: give it one of this world with retrack_actor(). SH bands that a set does not have are
/// dropped, missing ones are 0.
void add_actor(Scene& scene, const Scene& other, const std::string& name, const std::string& new_name);

}  // namespace simuli
