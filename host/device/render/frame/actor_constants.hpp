#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// Returns the ActorConstants of a frame as reals: one for the background and one per actor. centre_ref: o_ref
/// of the frame, scene frame. Sets `motion` if an actor present in the frame moves by more than the tolerance
/// for sensors at rest (sensor_in_frame()).
[[nodiscard]] std::vector<double> actor_constants(const std::vector<ActorView>& actors,
                                                  const Eigen::Vector3d& centre_ref,
                                                  bool& motion);

}  // namespace simuli
