#pragma once
#include <string>
#include <vector>

#include "host/device/render/train/adam.hpp"
#include "optim/actors/actor_poses.hpp"
#include "optim/actors/actor_shapes.hpp"
#include "optim/base/state.hpp"

namespace simuli {

/// Indices of the sets, for random streams and state names.
enum SetNumber : std::uint32_t { kCameraSet = 0, kLidarSet = 1 };

/// A particle set in training: parameters, gradients and optimiser state.
struct TrainedSet {
  TrainedSet(const Device& device, const GaussianSet& set, const PoseRates& pose_rates, bool learns_shapes);
  /// Resizes the gradients to the grown number of particles.
  void fit_gradients();
  /// Keeps the particles `kept` in that order, with their optimiser state. Waits.
  void keep(const std::vector<Eigen::Index>& kept);
  /// Sorts the particles by coherent_order() and returns it. Waits.
  std::vector<Eigen::Index> put_in_order();
  /// Freezes the colours of these particles: Adam no longer changes them. Waits.
  void freeze_colours(const std::vector<Eigen::Index>& of);
  /// Adds the checkpoint state, without poses and shapes of actors.
  void add_state(StateList& list, const std::string& name);
  ParticleBuffers particles;
  RealBuffer grads;  // [param_rows][stride]
  RealBuffer error;  // [N] reconstruction error since the last relocation
  AdamStage adam;
  ActorPoses poses;
  ActorShapes shapes;

 private:
  /// Implements keep() for the particles of `set`.
  void keep(const GaussianSet& set, const std::vector<Eigen::Index>& kept);
};

}  // namespace simuli
