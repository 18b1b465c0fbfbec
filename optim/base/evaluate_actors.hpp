#pragma once
// Which pixels and rays of a frame look at an actor: the part of the metrics that is about what moves.
#include <vector>

#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar_model.hpp"
#include "host/device/render/scene/actor_boxes.hpp"

namespace simuli {

/// [height][width]: the actor whose box the pixel's ray meets first, whatever stands before it; kNone: none.
[[nodiscard]] std::vector<int> pixels_on_actors(const ActorBoxes& boxes, const Camera& camera);

/// [rays]: the actor whose box the ray's recorded return is in; kNone: none. range: [rays] m, 0 for no
/// return.
[[nodiscard]] std::vector<int> returns_on_actors(const ActorBoxes& boxes,
                                                 const LidarModel& lidar,
                                                 const LidarRays& rays,
                                                 const std::vector<float>& range);

}  // namespace simuli
