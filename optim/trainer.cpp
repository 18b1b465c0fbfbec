#include "optim/trainer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "host/base/error.hpp"
#include "optim/frames.hpp"

namespace simuli {
namespace {

enum Stream : std::uint64_t { kImageStream = 1, kSweepStream = 2 };

RenderOptions training_options(RenderOptions options) {
  options.median_distance = false;  // has no gradient
  return options;
}

}  // namespace

void RunningMean::add(double value) {
  constexpr double kKeep = 0.95;
  sum = kKeep * sum + value;
  weight = kKeep * weight + 1.0;
}

double RunningMean::value() const {
  return weight > 0.0 ? sum / weight : std::numeric_limits<double>::quiet_NaN();
}

Trainer::Trainer(
    const Device& device, const Log& log, Scene scene, const TrainOptions& options, MovingSpace moving)
    : log_(log),
      scene_(std::move(scene)),
      options_(checked(options)),
      device_(device),
      renderer_(device, training_options(options_.render)),
      truth_(device, log, scene_, options_, renderer_.options(), std::move(moving)),
      camera_(device, scene_.camera),
      lidar_(device, scene_.lidar),
      look_(device, log, scene_, options_),
      regularize_(device, Precision::kFloat),
      images_(select_frames(log.images, options.held_out_every, false), options.seed, kImageStream),
      sweeps_(select_frames(log.sweeps, options.held_out_every, false), options.seed, kSweepStream) {
  if (images_.empty() && sweeps_.empty()) {
    throw_input_error(log.folder.string(), "training frames", "0", "at least one image or sweep");
  }
  status_.psnr_db = status_.distance_m = status_.drop_accuracy = std::numeric_limits<double>::quiet_NaN();
}

void Trainer::need_finite(double loss, const std::string& file) {
  if (std::isfinite(loss)) return;
  throw Error(ErrorKind::kNumeric, fmt::format("train: loss of {}: found {}", file, loss));
}

void Trainer::regularize(TrainedSet& set, const ParticleWeights& w) {
  const double count = std::max(1.0, static_cast<double>(set.particles.count));
  const RegularizeScale scale{w.scale / count, w.opacity / count, w.entropy / count};
  if (!scale.is_zero()) regularize_.run(set.particles, scale, set.grads);
}

void Trainer::step() {
  const double progress = static_cast<double>(status_.iteration) / std::max(1, options_.iterations);
  if (!images_.empty() && camera_.particles.count > 0) step_camera(progress);
  const bool lidar_turn = status_.iteration % options_.lidar_every == 0;
  if (lidar_turn && !sweeps_.empty() && lidar_.particles.count > 0) step_lidar(progress);
  ++status_.iteration;
}

TrainReport Trainer::run(const std::function<void(const TrainStatus&)>& on_step) {
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed_s = [begin] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  TrainReport report;
  while (status_.iteration < options_.iterations) {
    if (options_.max_seconds > 0.0 && elapsed_s() >= options_.max_seconds) {
      report.stopped_early = true;
      break;
    }
    step();
    if (on_step) on_step(status_);
  }
  device_.finish();
  report.last = status_;
  report.images = images_.size();
  report.sweeps = sweeps_.size();
  report.camera_particles = scene_.camera.size();
  report.lidar_particles = scene_.lidar.size();
  report.rejected_gradients = camera_.adam.rejected() + lidar_.adam.rejected() + look_.rejected();
  report.seconds = elapsed_s();
  return report;
}

Scene Trainer::scene() const {
  Scene out = scene_;
  out.camera = camera_.particles.download();
  out.lidar = lidar_.particles.download();
  look_.store(out);
  return out;
}

}  // namespace simuli
