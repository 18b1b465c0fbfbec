// The LiDAR set's share of an iteration: one sweep, its losses, one step of Adam.
#include <algorithm>

#include "optim/base/frames.hpp"
#include "optim/train/trainer.hpp"

namespace simuli {

void Trainer::step_lidar(double progress) {
  const std::size_t index = sweeps_.at(static_cast<std::uint64_t>(status_.iteration / options_.lidar_every));
  const SweepFrame& frame = log_.sweeps[index];
  const auto truth = truth_.sweep(index);
  Pass pass = renderer_.render(lidar_.particles, truth->truth.rays(), view(frame, frame.lidar));
  const double rays = std::max(1.0, static_cast<double>(truth->known));
  // A sweep without a return has no distance loss to weigh: its sums are zero.
  const double returned = std::max(1.0, static_cast<double>(truth->returned));
  const LidarWeights& w = options_.weights;
  const LidarLoss loss =
      pass.lidar_loss(truth->truth, {w.distance / returned, w.intensity / returned, w.drop / rays});
  const bool errors = collects_errors();
  if (errors) {
    densify_->beam_error(pass.frame(),
                         pass.buffers(),
                         truth->truth.slots(),
                         {w.distance, w.intensity, w.drop},
                         pass.ray_error());
  }
  pass.backward(
      lidar_.particles, lidar_.grads, {.errors = errors, .ray_gradients = offsets_.contains(frame.lidar)});
  if (errors) densify_->accumulate(pass.frame(), pass.buffers(), lidar_.error);
  step_pose(pass, frame.lidar, lidar_.grads, progress);
  regularize(lidar_, options_.lidar_particles);
  lidar_.adam.run(lidar_.particles,
                  lidar_.grads,
                  pass.buffers().keys,
                  row_rates(options_.lidar, lidar_.particles.sh_degree, progress));
  jitter(pass, lidar_, kLidarSet, options_.lidar, progress);
  step_actors(pass, lidar_, frame.time_start_s, frame.time_end_s, progress);
  if (!is_sound(loss.distance_m + loss.intensity + loss.entropy)) return;
  distance_.add(loss.distance_m / returned);
  right_.add(1.0 - loss.wrong / rays);
  status_.distance_m = distance_.value();
  status_.drop_accuracy = right_.value();
}

}  // namespace simuli
