#pragma once
#include <string>
#include <vector>

#include "host/device/render/train/adam.hpp"
#include "optim/actors/actor_poses.hpp"
#include "optim/actors/actor_shapes.hpp"
#include "optim/base/state.hpp"

namespace simuli {

/// Numbers of the sets, for random numbers and names of states.
enum SetNumber : std::uint32_t { kCameraSet = 0, kLidarSet = 1 };

/// A particle set in training: parameters, their gradients, and the optimiser's state.
struct TrainedSet {
  TrainedSet(const Device& device, const GaussianSet& set, const PoseRates& pose_rates, bool learns_shapes);
  /// Makes the gradients fit the particles after those have grown.
  void fit_gradients();
  /// Leaves the particles at `kept`, in that order, each with its optimiser's state. Waits.
  void keep(const std::vector<Eigen::Index>& kept);
  /// Puts them in coherent_order(), which it returns. Waits.
  std::vector<Eigen::Index> put_in_order();
  /// Adam leaves the colours of these particles as they are from now on. Waits.
  void freeze_colours(const std::vector<Eigen::Index>& of);
  /// What a checkpoint holds of it, but for the actors' poses and shapes.
  void add_state(StateList& list, const std::string& name);
  ParticleBuffers particles;
  RealBuffer grads;  // [param_rows][stride]
  RealBuffer error;  // [N] reconstruction error since the last relocation
  AdamStage adam;
  ActorPoses poses;
  ActorShapes shapes;

 private:
  /// keep() of the particles, which are `set`.
  void keep(const GaussianSet& set, const std::vector<Eigen::Index>& kept);
};

}  // namespace simuli
