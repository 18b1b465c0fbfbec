#include "optim/train/structure.hpp"

#include <algorithm>
#include <cmath>

#include "optim/train/paper/anchors.hpp"

namespace simuli {
namespace {

constexpr int kFirstDensified = 2;  // in multiples of densify.epochs, after the initial errors have fallen

}  // namespace

std::size_t epoch_of(const TrainOptions& options, std::size_t images, std::size_t sweeps) {
  const std::size_t frames = images > 0 ? images : sweeps * static_cast<std::size_t>(options.lidar_every);
  const auto shards = static_cast<std::size_t>(options.shards.count);
  return (frames + shards - 1) / shards;
}

int Structure::densify_every(const DensifyOptions& options, std::size_t epoch) {
  constexpr double kMost = 1e9;  // larger than any training's
  const double iterations = std::round(options.epochs * static_cast<double>(epoch));
  return static_cast<int>(std::clamp(iterations, 1.0, kMost));
}

Structure::Structure(const Device& device,
                     const TrainOptions& options,
                     std::size_t epoch,
                     std::uint64_t seed,
                     TrainedSet& camera,
                     TrainedSet& lidar)
    : options_(options),
      densify_every_(densify_every(options.densify, epoch)),
      seed_(seed),
      camera_(camera),
      lidar_(lidar),
      camera_start_(camera.particles.count),
      lidar_start_(lidar.particles.count),
      hook_(make_anchors(device, options, camera, lidar)) {
  if (options.densify.epochs > 0.0) densify_.emplace(device, Precision::kFloat);
}

bool Structure::collects_errors(SetNumber number, int iteration) const {
  return densify_ && (number == kCameraSet || options_.densify.lidar) &&
         iteration < DensifyOptions::kLastShare * options_.iterations;
}

void Structure::jitter(TrainedSet& set,
                       SetNumber number,
                       const LearningRates& rates,
                       const Buffer<std::uint32_t>& keys,
                       int iteration,
                       double progress) {
  if (!collects_errors(number, iteration) || !(options_.densify.noise > 0.0)) return;
  const double rate_m = row_rates(rates, 0, progress)[kMeanRow];
  densify_->jitter(set.particles,
                   keys,
                   options_.densify.noise * rate_m,
                   {seed_, static_cast<std::uint32_t>(iteration), number});
}

/// Returns the number of particles to add to a set.
std::uint32_t Structure::growth(SetNumber number) const {
  const DensifyOptions& o = options_.densify;
  const double count = (number == kCameraSet ? camera_ : lidar_).particles.count;
  const double both = static_cast<double>(camera_.particles.count) + lidar_.particles.count;
  // The remaining capacity is shared in proportion to the sets' growth.
  const double share = (static_cast<double>(o.cap) - both) / std::max(both, 1.0);
  const double room = o.most * (number == kCameraSet ? camera_start_ : lidar_start_) - count;
  return static_cast<std::uint32_t>(std::max(0.0, std::min(count * std::min(o.growth, share), room)));
}

void Structure::densify(int iteration) {
  if (!densify_ || iteration / densify_every_ < kFirstDensified || iteration % densify_every_ != 0) return;
  const std::uint32_t added[] = {growth(kCameraSet), growth(kLidarSet)};
  for (const SetNumber number : {kCameraSet, kLidarSet}) {
    if (!collects_errors(number, iteration)) continue;
    TrainedSet& set = number == kCameraSet ? camera_ : lidar_;
    RealBuffer* const moments[] = {&set.adam.first_moment(), &set.adam.second_moment()};
    const DensifyCounts counts = densify_->relocate(set.particles,
                                                    moments,
                                                    set.error,
                                                    added[number],
                                                    {seed_, static_cast<std::uint32_t>(iteration), number});
    set.fit_gradients();
    if (number == kCameraSet && hook_) hook_->relocate(*densify_);
    // Relocated and new particles are not in spatial order.
    const std::vector<Eigen::Index> order = set.put_in_order();
    if (hook_) hook_->reorder(number, order);
    relocated_ += counts.relocated;
    grown_ += counts.grown;
  }
}

void Structure::report(TrainReport& report) const {
  report.relocated = relocated_;
  report.grown = grown_;
  if (hook_) hook_->report(report);
}

void Structure::add_state(StateList& list) {
  list.add("relocated", relocated_);
  list.add("grown", grown_);
  if (hook_) hook_->add_state(list);
}

}  // namespace simuli
