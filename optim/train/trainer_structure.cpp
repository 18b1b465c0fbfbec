// What holds particles in place and what changes their number: anchors, relocation, growth, noise.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "optim/base/frames.hpp"
#include "optim/train/trainer.hpp"

namespace simuli {
namespace {

constexpr double kPoseFinalShare = 0.01;  // of the offsets' rates, at the end

/// Adds the time until it goes, the device's work included.
class Stopwatch {
 public:
  Stopwatch(const Device& device, double& seconds) : device_(device), seconds_(seconds) {
    device_.finish();
    begin_ = std::chrono::steady_clock::now();
  }
  void stop() {
    device_.finish();
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  const Device& device_;
  double& seconds_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace

template <class Frame>
View Trainer::view(const Frame& frame, const std::string& sensor) const {
  const View from_log = view_of(log_, scene_, frame);
  const auto offset = offsets_.find(sensor);
  return offset == offsets_.end() ? from_log : moved_by(offset->second, from_log);
}
template View Trainer::view(const ImageFrame& frame, const std::string& sensor) const;
template View Trainer::view(const SweepFrame& frame, const std::string& sensor) const;

void Trainer::step_pose(const std::string& sensor, const RealBuffer& grads, double progress) {
  const auto offset = offsets_.find(sensor);
  if (offset == offsets_.end()) return;
  const double share = std::pow(kPoseFinalShare, progress);
  offset->second.step(renderer_.pose_gradient(grads),
                      share * options_.poses.translation_m,
                      share * options_.poses.rotation_rad);
}

bool Trainer::collects_errors() const {
  return densify_ && status_.iteration < options_.densify.last_share * options_.iterations;
}

void Trainer::find_anchors() {
  if (!anchor_ || status_.iteration % options_.anchor.every != 0) return;
  Stopwatch watch(device_, anchor_seconds_);
  anchor_->assign(camera_.particles, lidar_.particles, options_.anchor.reach_m);
  watch.stop();
}

void Trainer::add_anchor_gradient() {
  if (!anchor_) return;
  Stopwatch watch(device_, anchor_seconds_);
  // A mean over all particles; those that the frame does not show make no step, and so need no gradient.
  anchor_->add_gradient(camera_.particles,
                        lidar_.particles,
                        renderer_.buffers().keys,
                        options_.anchor.weight / camera_.particles.count,
                        status_.iteration % options_.anchor.choose_every == 0,
                        camera_.grads);
  watch.stop();
}

void Trainer::jitter(TrainedSet& set, std::uint32_t number, const LearningRates& rates, double progress) {
  if (!collects_errors() || !(options_.densify.noise > 0.0)) return;
  const double rate_m = row_rates(rates, 0, progress)[kMeanRow];
  densify_->jitter(set.particles,
                   renderer_.buffers().keys,
                   options_.densify.noise * rate_m,
                   {seed_, static_cast<std::uint32_t>(status_.iteration), number});
}

void Trainer::densify() {
  const DensifyOptions& o = options_.densify;
  if (!collects_errors() || status_.iteration < o.first || status_.iteration % o.every != 0) return;
  Stopwatch watch(device_, densify_seconds_);
  const double count = static_cast<double>(camera_.particles.count) + lidar_.particles.count;
  // What is left to the cap is shared as the growth would be.
  const double room = std::max(0.0, static_cast<double>(o.cap) - count);
  const double growth = std::min(o.growth, room / std::max(count, 1.0));
  for (const std::uint32_t number : {kCameraSet, kLidarSet}) {
    TrainedSet& set = number == kCameraSet ? camera_ : lidar_;
    RealBuffer* const moments[] = {&set.adam.first_moment(), &set.adam.second_moment()};
    const DensifyCounts counts =
        densify_->relocate(set.particles,
                           moments,
                           set.error,
                           static_cast<std::uint32_t>(growth * set.particles.count),
                           {seed_, static_cast<std::uint32_t>(status_.iteration), number});
    set.fit_gradients();
    if (number == kCameraSet && anchor_) {
      densify_->follow(anchor_->candidates(), anchor_->neighbours());
      densify_->follow(anchor_->nearest(), 1);
    }
    relocated_ += counts.relocated;
    grown_ += counts.grown;
  }
  status_.camera_particles = camera_.particles.count;
  status_.lidar_particles = lidar_.particles.count;
  watch.stop();
}

}  // namespace simuli
