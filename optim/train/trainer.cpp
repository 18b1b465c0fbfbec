#include "optim/train/trainer.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/stopwatch.hpp"
#include "host/core/scene/particle_order.hpp"
#include "optim/train/pruning.hpp"

namespace simuli {
namespace {

/// Returns the largest difference in m between a row's range bias and the log's.
double largest_correction_m(const Log& log, const TruthCache& truth) {
  double largest_m = 0.0;
  for (const LogLidar& lidar : log.lidars) {
    const auto* const stated = std::get_if<Lidar>(&lidar.model);
    if (stated == nullptr) continue;
    const std::vector<LidarRow>& found = std::get<Lidar>(truth.lidar(stated->name)).rows;
    for (std::size_t row = 0; row < found.size(); ++row) {
      largest_m = std::max(largest_m, std::abs(found[row].range_bias - stated->rows[row].range_bias));
    }
  }
  return largest_m;
}

/// Returns the particles whose parameters are all finite, in order.
GaussianSet finite_ones(const GaussianSet& set) {
  if (set.params.allFinite()) return set;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < set.size(); ++i) {
    if (set.params.row(i).allFinite()) kept.push_back(i);
  }
  return subset(set, kept);
}

}  // namespace

Trainer::Trainer(
    const Device& device, const Log& log, Scene scene, const TrainingOptions& options, Ranks& ranks)
    : ranks_(ranks),
      state_(device, log, std::move(scene), options),
      shards_(device, static_cast<std::size_t>(options.train.shards.count), ranks) {
  for (const auto make : {picture_loss_term, repaired_loss_term, off_trajectory_loss_term, depth_loss_term, sweep_loss_term}) {
    loss_terms_.push_back(make(state_));
  }
}

void Trainer::step() {
  TrainerState& s = state_;
  const double progress = static_cast<double>(s.status.iteration) / std::max(1, s.options.iterations);
  const bool prunes = is_prune_turn(s);
  if (prunes) prune(s);
  if (SetHook* const hook = s.structure.hook()) hook->begin(s.status.iteration, prunes);
  read_ahead();
  for (const auto& loss_term : loss_terms_) {
    if (loss_term->is_due()) loss_term->step(shards_, progress);
  }
  ++s.status.iteration;
  s.structure.densify(s.status.iteration);
  if (s.options.length.automatic && s.status.iteration == s.options.iterations) end_stage();
  s.status.camera_particles = s.camera.particles.count;
  s.status.lidar_particles = s.lidar.particles.count;
}

void Trainer::repair(const std::function<void(const TrainStatus&)>& on_step) {
  const int iteration = state_.status.iteration;
  if (!state_.repaired.is_due(iteration, state_.options.iterations)) return;
  try {
    state_.repaired.repair({scene(), state_.log.cameras, state_.log.lidars, state_.log.world_from_rig},
                       iteration);
  } catch (...) {
    if (on_step) on_step(state_.status);
    throw;
  }
}

/// Requests sweeps of the sweep loss only: with one LiDAR the depth loss uses the same ones.
void Trainer::read_ahead() {
  const auto next = [this](FrameOrder& order, int turn) {
    constexpr std::uint64_t kFrames = 4;
    const std::uint64_t shards = shards_.count();
    std::vector<std::size_t> frames;
    for (std::uint64_t k = 0; !order.empty() && k < std::max(kFrames, shards); ++k) {
      frames.push_back(order.at((static_cast<std::uint64_t>(turn) + 1) * shards + k));
    }
    return frames;
  };
  const int iteration = state_.status.iteration;
  state_.truth.expect(next(state_.images, iteration),
                      next(state_.sweeps, iteration / state_.options.lidar_every));
}

void Trainer::end_stage() {
  const int next = state_.length.end_stage(state_.status.iteration);
  if (next == 0) return;
  state_.options.iterations = next;
  state_.status.planned = next;
}

TrainReport Trainer::run(const std::function<void(const TrainStatus&)>& on_step) {
  const Stopwatch watch;
  const TrainStatus& status = state_.status;
  const double max_seconds = state_.options.max_seconds;
  TrainReport report;
  report.first_iteration = status.iteration;
  report.begin = status;
  constexpr int kStart = 5;  // iterations that define the initial scores; a diverging training fails early
  while (status.iteration < state_.options.iterations) {
    if (max_seconds > 0.0 && ranks_.any(watch.seconds() >= max_seconds)) {
      report.stopped_early = true;
      break;
    }
    repair(on_step);
    step();
    if (status.iteration - report.first_iteration <= kStart) {
      // fmin and fmax ignore NaN.
      report.begin.psnr_db = std::fmax(report.begin.psnr_db, status.psnr_db);
      report.begin.distance_m = std::fmin(report.begin.distance_m, status.distance_m);
      report.begin.drop_accuracy = std::fmax(report.begin.drop_accuracy, status.drop_accuracy);
    }
    if (on_step) on_step(status);
  }
  state_.device.finish();
  report.last = status;
  report.images = state_.images.size();
  report.sweeps = state_.sweeps.size();
  state_.structure.report(report);
  report.pruned = state_.pruned;
  report.row_ranges_m = largest_correction_m(state_.log, state_.truth);
  report.rejected_gradients = state_.appearance.rejected();
  for (TrainedSet* const set : {&state_.camera, &state_.lidar}) {
    const Eigen::Index count = set->particles.count;
    (set == &state_.camera ? report.camera_particles : report.lidar_particles) = count;
    report.rejected_gradients += set->adam.rejected();
    report.unsound_particles +=
        static_cast<std::uint64_t>(count - finite_ones(set->particles.download()).size());
  }
  report.unsound_losses = state_.unsound_losses;
  report.stages = state_.length.stages();
  report.ranks = ranks_.size();
  report.gathered_bytes = shards_.gathered_bytes();
  report.seconds = watch.seconds();
  return report;
}

Scene Trainer::scene() const {
  Scene out = state_.scene;
  out.camera = finite_ones(state_.camera.particles.download());
  out.lidar = finite_ones(state_.lidar.particles.download());
  state_.appearance.store(out);
  state_.drop.store(out);
  return in_coherent_order(std::move(out));  // training has moved the particles
}

void Trainer::save(const std::filesystem::path& file, const std::string& settings) {
  state_.list(settings).write(file);
}

void Trainer::need_one_state(const std::string& settings) {
  if (ranks_.size() == 1) return;
  std::vector<RankField> fields;
  for (const auto& [name, hash] : state_.list(settings).hashes())
    fields.push_back({name, fmt::format("{:016x}", hash)});
  need_same(ranks_, fields);
}

void Trainer::resume(const std::filesystem::path& file, const std::string& settings) {
  state_.list(settings).read(file);
  state_.status.planned = state_.options.iterations;  // may exceed the planned iterations of the checkpoint
  for (TrainedSet* set : {&state_.camera, &state_.lidar}) {
    set->fit_gradients();
    set->particles.refresh_actors();
  }
}

}  // namespace simuli
