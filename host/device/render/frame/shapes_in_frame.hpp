#pragma once
// The shapes of actors that are not rigid, as one frame sees them.
#include <cstdint>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/device/render/rays/ray_grid.hpp"

namespace simuli {

/// What is not there, or rigid, has no shape.
struct ShapesInFrame {
  std::vector<std::uint32_t> at;  // [1 + A]: where each actor's is in `reals`; all ones: it has none
  std::vector<double> reals;      // as cl/math/deform.h takes them
  std::vector<double> share;      // [A]: of the frame at which the sensor sees the actor

  [[nodiscard]] bool empty() const { return reals.empty(); }
};

/// A shape stands still during the frame, at the time at which the sensor looks at the actor's middle: what
/// takes a tenth of a second for all around looks at a person for a few milliseconds.
[[nodiscard]] ShapesInFrame shapes_in_frame(const std::vector<ActorView>& actors,
                                            const RayGrid& grid,
                                            const Pose& scene_from_sensor_start,
                                            const Pose& scene_from_sensor_end);

}  // namespace simuli
