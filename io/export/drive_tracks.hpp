#pragma once
#include <string>

#include "io/base/json_reader.hpp"
#include "io/scene/scene_clock.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// AlpaSim's rig_trajectories.json: the path, m from the scene's origin, the cameras and when their pictures
/// were taken. An instant is a microsecond long: it asks for ends behind starts.
[[nodiscard]] Json rig_trajectories(const SceneFile& scene,
                                    const SceneClock& clock,
                                    const std::string& sequence);

/// AlpaSim's sequence_tracks.json: actors' boxes and their centres' poses, m from the scene's origin, xyz and
/// quaternion xyzw. An actor with one pose stands there for as long as it is there.
[[nodiscard]] Json sequence_tracks(const Scene& scene, const SceneClock& clock);

}  // namespace simuli
