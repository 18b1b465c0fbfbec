#pragma once
// Deformations of non-rigid actors in one frame.
#include <cstdint>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/device/render/rays/ray_grid.hpp"

namespace simuli {

/// Absent and rigid actors have no deformation.
struct ShapesInFrame {
  std::vector<std::uint32_t> at;  // [1 + A]: index of each actor's grid in `reals`; all ones: none
  std::vector<double> reals;  // in the layout of cl/math/deform.h
  std::vector<double> share;  // [A]: share of the frame at which the sensor observes the actor

  [[nodiscard]] bool empty() const { return reals.empty(); }
};

/// Returns the deformations, constant during the frame, at the time when the sensor observes the middle of each
/// actor: a sweep of a tenth of a second observes a pedestrian for a few milliseconds.
[[nodiscard]] ShapesInFrame shapes_in_frame(const std::vector<ActorView>& actors,
                                            const RayGrid& grid,
                                            const Pose& scene_from_sensor_start,
                                            const Pose& scene_from_sensor_end);

}  // namespace simuli
