#pragma once
#include <string>
#include <vector>

#include "io/base/json_reader.hpp"
#include "io/scene/scene_clock.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// Returns AlpaSim's rig_trajectories.json: the trajectory in metres from the scene's origin, the cameras and
/// the exposure times of their pictures. An instant lasts a microsecond, because ends must be after starts.
[[nodiscard]] Json rig_trajectories(const SceneFile& scene,
                                    const SceneClock& clock,
                                    const std::string& sequence);

/// Returns the rig's poses in time order, in metres from the scene's origin.
[[nodiscard]] std::vector<Pose> local_path(const SceneFile& scene);

/// Returns AlpaSim's sequence_tracks.json: actors' boxes and the poses of their centres in metres from the
/// scene's origin, xyz and quaternion xyzw. An actor with one pose is static while it is present; one with more
/// is DYNAMIC, because CARLA's client moves no others. Kinds are those of label_class_of().
[[nodiscard]] Json sequence_tracks(const Scene& scene, const SceneClock& clock);

}  // namespace simuli
