#pragma once
// Pixels and rays of a frame that belong to actors, for scores of moving objects.
#include <vector>

#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/device/render/scene/actor_boxes.hpp"

namespace simuli {

/// [height][width]: the actor whose box the pixel's ray enters first, ignoring occluders; kNone without one.
[[nodiscard]] std::vector<int> pixels_on_actors(const ActorBoxes& boxes, const Camera& camera);

/// [rays]: the actor whose box contains the ray's recorded return; kNone without one. range: [rays] m, 0 for no
/// return.
[[nodiscard]] std::vector<int> returns_on_actors(const ActorBoxes& boxes,
                                                 const LidarModel& lidar,
                                                 const LidarRays& rays,
                                                 const std::vector<float>& range);

}  // namespace simuli
