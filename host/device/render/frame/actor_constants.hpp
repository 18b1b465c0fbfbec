#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/core/scene/actor.hpp"

namespace simuli {

/// The ActorConstants of a frame, as reals: one for the background, one per actor. centre_ref: o_ref of the
/// frame, scene frame. Fills `motion`: an actor that is there moves by more than a sensor at rest may
/// (sensor_in_frame()).
[[nodiscard]] std::vector<double> actor_constants(const std::vector<ActorView>& actors,
                                                  const Eigen::Vector3d& centre_ref,
                                                  bool& motion);

}  // namespace simuli
