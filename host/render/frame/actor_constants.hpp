#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/scene/actor.hpp"

namespace simuli {

/// The rows SIM_A_.. of a frame: one for the background, one per actor. centre_ref: o_ref of the frame, scene
/// frame. Fills `motion`: an actor that is there moves by more than a sensor at rest may
/// (frame_constants()).
[[nodiscard]] std::vector<double> actor_constants(const std::vector<ActorView>& actors,
                                                  const Eigen::Vector3d& centre_ref,
                                                  bool& motion);

}  // namespace simuli
