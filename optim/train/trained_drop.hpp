#pragma once
// Training of the LiDARs' ray-drop functions (METHOD section 7).
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "optim/actors/small_adam.hpp"
#include "optim/base/state.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

class TrainedDrop {
 public:
  /// One function per LiDAR of the log: the scene's if it has one.
  TrainedDrop(const Log& log, const Scene& scene, const TrainingOptions& options);

  [[nodiscard]] RayDrop::Parameters of(const std::string& lidar) const;
  /// Returns the weights of a sweep's ray-drop loss for the function and for the particles. Particles overfit
  /// the dropped rays of their training sweeps, and a function trained on the same sweeps would rely on them
  /// too much; so some sweeps train only the function and the others only the particles. `sweep`: an index into
  /// log.sweeps.
  [[nodiscard]] LidarLossScale share(std::size_t sweep, LidarLossScale scale) const;
  using Function = SmallAdam<RayDrop::kParameters>;
  /// Computes the losses of a pass rendered with of(lidar), weighted by share(), which give the particles'
  /// gradient; before, the function takes its steps on the sweep, if the sweep trains it. `taught` receives the
  /// trained function for take().
  LidarLoss learn(Pass& pass,
                  const RayValues& truth,
                  std::size_t sweep,
                  const std::string& lidar,
                  const LidarLossScale& scale,
                  double progress,
                  std::vector<Function>& taught) const;
  /// Replaces a LiDAR's function by the mean of the functions from the sweeps of one step, added in order.
  void take(const std::string& lidar, const std::vector<Function>& functions);
  void store(Scene& scene) const;
  /// Adds the checkpoint state.
  void add_state(StateList& list);

 private:
  RayDropOptions options_;
  std::vector<bool> teaches_function_, teaches_particles_;  // [log.sweeps]
  std::map<std::string, Function> functions_;  // by name of the LiDAR
};

}  // namespace simuli
