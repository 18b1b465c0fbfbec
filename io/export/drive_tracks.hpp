#pragma once
#include <string>
#include <vector>

#include "io/base/json_reader.hpp"
#include "io/scene/scene_clock.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// AlpaSim's rig_trajectories.json: the path, m from the scene's origin, the cameras and when their pictures
/// were taken. An instant is a microsecond long: it asks for ends behind starts.
[[nodiscard]] Json rig_trajectories(const SceneFile& scene,
                                    const SceneClock& clock,
                                    const std::string& sequence);

/// The rig's poses in order of time, m from the scene's origin.
[[nodiscard]] std::vector<Pose> local_path(const SceneFile& scene);

/// AlpaSim's sequence_tracks.json: actors' boxes and their centres' poses, m from the scene's origin, xyz and
/// quaternion xyzw. An actor with one pose stands there for as long as it is there; one with more is DYNAMIC,
/// as CARLA's client moves no others. Kinds by the names of label_class_of().
[[nodiscard]] Json sequence_tracks(const Scene& scene, const SceneClock& clock);

}  // namespace simuli
