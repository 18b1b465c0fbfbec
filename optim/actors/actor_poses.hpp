#pragma once
// Optimises the key poses of actors (METHOD section 2).
#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/core/scene/actor.hpp"
#include "host/device/render/train/actor.hpp"
#include "optim/actors/pose_rates.hpp"

namespace simuli {

/// The optimiser of key poses for one particle set; all sets share the poses.
class ActorPoses {
 public:
  explicit ActorPoses(const PoseRates& rates) : rates_(rates) {}
  [[nodiscard]] bool learns() const { return rates_.learn; }

  /// Takes one step with the gradients of a frame, in the order of `actors`. A pose between two keys moves both
  /// by its interpolation weights, which holds for rotations up to the rotation between the keys. Only keys
  /// used by the frame move.
  void step(std::vector<Actor>& actors,
            const std::vector<ActorPoseGradient>& gradients,
            double time_start_s,
            double time_end_s,
            double progress);

  /// Checkpoint state of the optimiser: kNumbers for each key pose of `actors`, in order.
  [[nodiscard]] std::vector<double> numbers(const std::vector<Actor>& actors) const;
  void set_numbers(const std::vector<Actor>& actors, std::span<const double> numbers);

 private:
  static constexpr std::size_t kNumbers = 13;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  struct Moments {
    Vector6 first = Vector6::Zero();
    Vector6 second = Vector6::Zero();
    int steps = 0;
  };

  PoseRates rates_;
  std::vector<std::vector<Moments>> moments_;  // [actors][keys]
};

}  // namespace simuli
