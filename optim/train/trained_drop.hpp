#pragma once
// The drop functions of the LiDARs in training (METHOD section 7).
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
  /// One for each LiDAR of the log: the scene's own, where it has one.
  TrainedDrop(const Log& log, const Scene& scene, const TrainingOptions& options);

  [[nodiscard]] RayDrop::Parameters of(const std::string& lidar) const;
  /// The weight of a sweep's drops in what the function learns, beside that in what particles do. Particles
  /// come to know by heart which rays of their sweeps dropped; a function that learned there would believe
  /// them too much. So the drops of some sweeps teach the function alone, and those of the others particles
  /// alone. `sweep`: an index into log.sweeps.
  [[nodiscard]] LidarLossScale share(std::size_t sweep, LidarLossScale scale) const;
  using Function = SmallAdam<RayDrop::kParameters>;
  /// The losses of a pass that was rendered with of(lidar), as share() weighs them, which leave the
  /// particles' gradient; before that the function takes its steps on the sweep, where it learns from it.
  /// What it is then goes to `taught`, for take().
  LidarLoss learn(Pass& pass,
                  const RayValues& truth,
                  std::size_t sweep,
                  const std::string& lidar,
                  const LidarLossScale& scale,
                  double progress,
                  std::vector<Function>& taught) const;
  /// Takes over the mean of what sweeps of one step have taught of a LiDAR's function, added in their order.
  void take(const std::string& lidar, const std::vector<Function>& functions);
  void store(Scene& scene) const;
  /// What a checkpoint holds of it.
  void add_state(StateList& list);

 private:
  RayDropOptions options_;
  std::vector<bool> teaches_function_, teaches_particles_;  // [log.sweeps]
  std::map<std::string, Function> functions_;               // by name of the LiDAR
};

}  // namespace simuli
