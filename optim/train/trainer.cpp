#include "optim/train/trainer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "host/base/error.hpp"
#include "optim/base/frames.hpp"
#include "optim/train/memory.hpp"

namespace simuli {
namespace {

enum Stream : std::uint64_t { kImageStream = 1, kSweepStream = 2 };

RenderOptions training_options(RenderOptions options) {
  options.median_distance = false;  // has no gradient
  return options;
}

const TrainOptions& fitting(const Device& device,
                            const Log& log,
                            const Scene& scene,
                            const TrainingOptions& options) {
  static_cast<void>(checked(options));
  need_memory(device, log, scene, options);
  return options.train;
}

/// The particles all of whose parameters are finite, in their order.
GaussianSet finite_ones(const GaussianSet& set) {
  if (set.params.allFinite()) return set;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    if (set.params.row(i).allFinite()) kept.push_back(i);
  }
  GaussianSet out(set.kind, set.sh_degree, static_cast<Eigen::Index>(kept.size()));
  out.params = set.params(kept, Eigen::all);
  if (!set.actor.empty()) {
    for (const Eigen::Index i : kept) out.actor.push_back(set.actor[static_cast<std::size_t>(i)]);
  }
  return out;
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
    const Device& device, const Log& log, Scene scene, const TrainingOptions& options, MovingSpace moving)
    : log_(log),
      scene_(std::move(scene)),
      options_(fitting(device, log, scene_, options)),
      seed_(options.frames.seed),
      device_(device),
      renderer_(device, training_options(options_.render)),
      truth_(device, log, scene_, options, renderer_.options(), std::move(moving)),
      camera_(device, scene_.camera, options_.actor_poses),
      lidar_(device, scene_.lidar, options_.actor_poses),
      look_(device, log, scene_, options),
      regularize_(device, Precision::kFloat),
      images_(select_frames(log.images, options.frames.held_out_every, false), seed_, kImageStream),
      sweeps_(select_frames(log.sweeps, options.frames.held_out_every, false), seed_, kSweepStream) {
  if (images_.empty() && sweeps_.empty()) {
    throw_input_error(log.folder.string(), "training frames", "0", "at least one image or sweep");
  }
  status_.camera_particles = camera_.particles.count;
  status_.lidar_particles = lidar_.particles.count;
  status_.psnr_db = status_.distance_m = status_.drop_accuracy = std::numeric_limits<double>::quiet_NaN();
  if (options_.anchor.weight > 0.0 && camera_.particles.count > 0 && lidar_.particles.count > 0) {
    anchor_.emplace(device, Precision::kFloat, static_cast<std::uint32_t>(options_.anchor.neighbours));
  }
  if (options_.densify.every > 0) densify_.emplace(device, Precision::kFloat);
  if (options_.poses.camera) {
    for (const LogCamera& camera : log.cameras) offsets_[camera.model.name];
  }
  if (options_.poses.lidar) {
    for (const LogLidar& lidar : log.lidars) offsets_[name_of(lidar.model)];
  }
}

bool Trainer::is_sound(double loss) {
  if (std::isfinite(loss)) return true;
  ++unsound_losses_;
  return false;
}

void Trainer::regularize(TrainedSet& set, const ParticleWeights& w) {
  const double count = std::max(1.0, static_cast<double>(set.particles.count));
  const RegularizeScale scale{w.scale / count, w.opacity / count, w.entropy / count};
  if (!scale.is_zero()) regularize_.run(set.particles, scale, set.grads);
}

void Trainer::step_actors(TrainedSet& set, double time_start_s, double time_end_s, double progress) {
  if (set.particles.actors == 0) return;
  renderer_.confine(set.particles, scene_.actors, options_.actor_margin_m);
  if (!set.poses.learns()) return;
  set.poses.step(scene_.actors, renderer_.pose_gradients(set.particles), time_start_s, time_end_s, progress);
}

void Trainer::step() {
  const double progress = static_cast<double>(status_.iteration) / std::max(1, options_.iterations);
  find_anchors();
  if (!images_.empty() && camera_.particles.count > 0) step_camera(progress);
  const bool lidar_turn = status_.iteration % options_.lidar_every == 0;
  if (lidar_turn && !sweeps_.empty() && lidar_.particles.count > 0) step_lidar(progress);
  ++status_.iteration;
  densify();
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
  report.camera_particles = camera_.particles.count;
  report.lidar_particles = lidar_.particles.count;
  report.relocated = relocated_;
  report.grown = grown_;
  if (anchor_) report.anchor_m = anchor_->loss().mean_m();
  report.anchor_seconds = anchor_seconds_;
  report.densify_seconds = densify_seconds_;
  report.rejected_gradients = camera_.adam.rejected() + lidar_.adam.rejected() + look_.rejected();
  report.unsound_particles = (camera_.particles.count - finite_ones(camera_.particles.download()).size()) +
                             (lidar_.particles.count - finite_ones(lidar_.particles.download()).size());
  report.unsound_losses = unsound_losses_;
  report.seconds = elapsed_s();
  return report;
}

Scene Trainer::scene() const {
  Scene out = scene_;
  out.camera = finite_ones(camera_.particles.download());
  out.lidar = finite_ones(lidar_.particles.download());
  look_.store(out);
  return out;
}

}  // namespace simuli
