// One iteration: a picture and its losses for the camera set, a sweep for the LiDAR set.
#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/scene/splitmix.hpp"
#include "optim/base/frames.hpp"
#include "optim/log/row_offsets.hpp"
#include "optim/train/trainer.hpp"

namespace simuli {
namespace {

constexpr std::uint64_t kBesideStream = 3;  // of numbers drawn

}  // namespace

void Trainer::step() {
  const double progress = static_cast<double>(status_.iteration) / std::max(1, options_.iterations);
  const bool prunes_now = prunes(status_.iteration);
  if (prunes_now) look_over_sweeps();
  structure_.find_anchors(status_.iteration, prunes_now);
  if (mended_.is_due(status_.iteration, options_.iterations)) mend();
  read_ahead();
  if (!images_.empty() && camera_.particles.count > 0) step_camera(progress);
  if (const FixedView* const mended = mended_.turn(status_.iteration)) step_mended(*mended, progress);
  const bool is_beside_turn = options_.beside.weight > 0.0 && status_.iteration % options_.beside.every == 0;
  if (is_beside_turn && !images_.empty() && camera_.particles.count > 0 && lidar_.particles.count > 0)
    step_beside(progress);
  const bool is_depth_turn = options_.depth.weight > 0.0 && status_.iteration % options_.depth.every == 0;
  if (is_depth_turn && !images_.empty() && !sweeps_.empty() && camera_.particles.count > 0)
    step_depth(progress);
  const bool is_lidar_turn = status_.iteration % options_.lidar_every == 0;
  if (is_lidar_turn && !sweeps_.empty() && lidar_.particles.count > 0) step_lidar(progress);
  ++status_.iteration;
  structure_.densify(status_.iteration);
  if (options_.length.automatic && status_.iteration == options_.iterations) end_stage();
  status_.camera_particles = camera_.particles.count;
  status_.lidar_particles = lidar_.particles.count;
}

/// What the next iterations take first; of sweeps those of the LiDAR set, as depth's are the same ones.
void Trainer::read_ahead() {
  const auto next = [this](FrameOrder& order, int turn) {
    constexpr std::uint64_t kFrames = 4;
    const auto shards = static_cast<std::uint64_t>(options_.shards.count);
    std::vector<std::size_t> frames;
    for (std::uint64_t k = 0; !order.empty() && k < std::max(kFrames, shards); ++k) {
      frames.push_back(order.at((static_cast<std::uint64_t>(turn) + 1) * shards + k));
    }
    return frames;
  };
  truth_.expect(next(images_, status_.iteration), next(sweeps_, status_.iteration / options_.lidar_every));
}

void Trainer::end_stage() {
  const int next = length_.end_stage(status_.iteration);
  if (next == 0) return;
  options_.iterations = next;
  status_.planned = next;
}

Trainer::Turn Trainer::camera_turn(double progress) {
  const bool errors = structure_.collects_errors(kCameraSet, status_.iteration);
  return {camera_,
          kCameraSet,
          options_.camera,
          progress,
          look_.harmonics_epsilon(camera_.particles.count),
          errors};
}

Trainer::Turn Trainer::lidar_turn(double progress) {
  const bool errors = structure_.collects_errors(kLidarSet, status_.iteration);
  return {lidar_, kLidarSet, options_.lidar, progress, 0.0, errors};
}

void Trainer::step_camera(double progress) {
  if (has_shards()) return step_camera_shards(progress);
  const std::size_t index = images_.at(static_cast<std::uint64_t>(status_.iteration));
  const ImageFrame& frame = log_.images[index];
  const Turn turn = camera_turn(progress);
  Shown shown = show_picture(turn, index);
  look_.step(index, static_cast<std::uint64_t>(status_.iteration), progress);
  descend(turn, shown.pass, {frame.camera, frame.time_start_s, frame.time_end_s});
  note_picture(index, shown.losses);
}

Trainer::Shown Trainer::show_picture(const Turn& turn, std::size_t index) {
  const ImageFrame& frame = log_.images[index];
  const auto truth = truth_.image(index);
  Pass pass = renderer_.render(
      camera_.particles, truth_.camera_rays(frame.camera), view_of(log_, scene_, frame), look_.environment());
  look_.grade(pass, index);
  const double values = 3.0 * std::max(1.0, static_cast<double>(truth->known));
  const ImageWeights& w = options_.image;
  const ImageLoss loss =
      pass.image_loss(truth->truth, {w.absolute / values, w.squared / values, w.dissimilarity / values});
  if (turn.errors) {
    structure_.errors().pixel_error(
        pass.frame(), pass.buffers().rays, pass.picture(), truth->truth.slots(), pass.ray_error());
  }
  look_.backward(pass, index);
  return {std::move(pass), {loss.absolute + loss.squared + loss.dissimilarity, loss.squared / values}};
}

void Trainer::note_picture(std::size_t index, std::span<const double> losses) {
  if (!is_sound(losses[0])) return;
  square_.add(losses[1]);
  length_.add_image(index, losses[1]);
  status_.psnr_db = -10.0 * std::log10(square_.value());
}

void Trainer::mend() {
  const SceneFile file{scene(), log_.cameras, log_.lidars, log_.world_from_rig};
  mended_.mend(file, status_.iteration);
}

void Trainer::step_mended(const FixedView& mended, double progress) {
  if (camera_.particles.count == 0) return;
  const SensorRays& rays = truth_.camera_rays(mended.camera);
  Pass pass = renderer_.render(
      camera_.particles, rays, view_of(scene_, mended.shot, SetKind::kCamera), look_.environment());
  const double share = mended_.weight() / (3.0 * static_cast<double>(mended.known));
  const ImageWeights& w = options_.image;
  const ImageLoss loss = pass.image_loss(RayValues(rays, mended.values, 3, "mended picture"),
                                         {w.absolute * share, w.squared * share, w.dissimilarity * share});
  if (look_.environment() != nullptr) {
    RealBuffer texels(device_, "environment's share of a mended picture", Precision::kFloat);
    pass.environment_backward(*look_.environment(), 0.0, texels);
  }
  pass.backward(camera_.particles, camera_.grads);
  take_step(camera_turn(progress), camera_.grads, pass.buffers().projected.keys);
  static_cast<void>(is_sound(loss.absolute + loss.squared + loss.dissimilarity));
}

void Trainer::step_beside(double progress) {
  if (has_shards()) return step_beside_shards(progress);
  const auto number = static_cast<std::uint64_t>(status_.iteration);
  Shown shown = show_beside(images_.at(number), number);
  take_step(camera_turn(progress), camera_.grads, shown.pass.buffers().projected.keys);
  static_cast<void>(is_sound(shown.losses[0]));
}

Trainer::Shown Trainer::show_beside(std::size_t index, std::uint64_t number) {
  const ImageFrame& frame = log_.images[index];
  const SensorRays& rays = truth_.camera_rays(frame.camera);
  const double left_m = options_.beside.reach_m * (2.0 * drawn(seed_, kBesideStream, number) - 1.0);
  const Shot shot = shot_of(log_, frame).beside(log_.camera(frame.camera).rig_from_camera, left_m);
  const View there = view_of(scene_, shot, SetKind::kCamera);
  RayValues& shown = beside_.try_emplace(frame.camera, rays, 3, "picture from beside").first->second;
  renderer_.render(lidar_.particles, rays, view_of(log_, scene_, frame)).keep_surfaces(surfaces_);
  renderer_.render(lidar_.particles, rays, there).show_from(surfaces_, truth_.image(index)->truth, shown);

  Pass pass = renderer_.render(camera_.particles, rays, there, look_.environment());
  look_.grade(pass, index);
  // Of all pixels: how many are known only the device knows.
  const double share = options_.beside.weight / (3.0 * static_cast<double>(rays.grid().rays));
  const ImageWeights& w = options_.image;
  const ImageLoss loss =
      pass.image_loss(shown, {w.absolute * share, w.squared * share, w.dissimilarity * share});
  look_.backward(pass, index);
  pass.backward(camera_.particles, camera_.grads);
  return {std::move(pass), {loss.absolute + loss.squared + loss.dissimilarity}};
}

void Trainer::step_depth(double progress) {
  if (has_shards()) return step_depth_shards(progress);
  Shown shown = show_depth(sweeps_.at(static_cast<std::uint64_t>(status_.iteration / options_.depth.every)));
  take_step(camera_turn(progress), camera_.grads, shown.pass.buffers().projected.keys);
  static_cast<void>(is_sound(shown.losses[0]));
}

Trainer::Shown Trainer::show_depth(std::size_t index) {
  const SweepFrame& frame = log_.sweeps[index];
  const auto truth = truth_.sweep(index);
  Pass pass = renderer_.render(camera_.particles, truth->truth.rays(), view_of(log_, scene_, frame));
  const double returned = std::max(1.0, static_cast<double>(truth->returned));
  const LidarLoss loss = pass.lidar_loss(truth->truth, {.distance = options_.depth.weight / returned});
  pass.backward(camera_.particles, camera_.grads);
  return {std::move(pass), {loss.distance_m}};
}

void Trainer::step_lidar(double progress) {
  if (has_shards()) return step_lidar_shards(progress);
  const std::size_t index = sweeps_.at(static_cast<std::uint64_t>(status_.iteration / options_.lidar_every));
  const SweepFrame& frame = log_.sweeps[index];
  const Turn turn = lidar_turn(progress);
  Shown shown = show_sweep(turn, index, nullptr);
  descend(turn, shown.pass, {frame.lidar, frame.time_start_s, frame.time_end_s});
  note_sweep(index, shown.losses);
}

Trainer::Shown Trainer::show_sweep(const Turn& turn,
                                   std::size_t index,
                                   std::vector<TrainedDrop::Function>* taught) {
  const SweepFrame& frame = log_.sweeps[index];
  const auto truth = truth_.sweep(index);
  View seen = view_of(log_, scene_, frame);
  seen.drop = drop_.of(frame.lidar);
  Pass pass = renderer_.render(lidar_.particles, truth->truth.rays(), seen);
  const double rays = std::max(1.0, static_cast<double>(truth->known));
  // A sweep without a return has no distance loss to weigh: its sums are zero.
  const double returned = std::max(1.0, static_cast<double>(truth->returned));
  const LidarWeights& w = options_.weights;
  const LidarLossScale scale{w.distance / returned, w.intensity / returned, w.drop / rays};
  LidarLoss loss;
  if (taught == nullptr) {
    loss = drop_.learn(pass, truth->truth, index, frame.lidar, scale, turn.progress);
  } else {
    TrainedDrop::Lesson lesson =
        drop_.learn_apart(pass, truth->truth, index, frame.lidar, scale, turn.progress);
    loss = lesson.loss;
    *taught = std::move(lesson.function);
  }
  if (turn.errors) {
    structure_.errors().beam_error(pass.frame(),
                                   pass.buffers().rays,
                                   pass.buffers().blended,
                                   truth->truth.slots(),
                                   {w.distance, w.intensity, w.drop},
                                   pass.ray_error());
  }
  return {std::move(pass),
          {loss.distance_m + loss.intensity + loss.entropy,
           loss.distance_m / returned,
           (w.distance * loss.distance_m + w.intensity * loss.intensity) / returned +
               w.drop * loss.entropy / rays,
           1.0 - loss.wrong / rays}};
}

void Trainer::note_sweep(std::size_t index, std::span<const double> losses) {
  if (!is_sound(losses[0])) return;
  distance_.add(losses[1]);
  length_.add_sweep(index, losses[2]);
  right_.add(losses[3]);
  status_.distance_m = distance_.value();
  status_.drop_accuracy = right_.value();
}

void Trainer::differentiate(const Turn& turn, Pass& pass, RealBuffer& error) {
  TrainedSet& set = turn.set;
  pass.backward(set.particles, set.grads, {.errors = turn.errors});
  if (turn.errors) {
    structure_.errors().accumulate(pass.frame(), pass.buffers(), pass.gradients(), error);
  }
  if (turn.number == kCameraSet) structure_.add_anchor_gradient(pass, status_.iteration);
}

void Trainer::take_step(const Turn& turn, const RealBuffer& grads, const Buffer<std::uint32_t>& keys) {
  TrainedSet& set = turn.set;
  const int degree = set.particles.sh_degree;
  set.adam.run(set.particles,
               grads,
               keys,
               {row_rates(turn.rates, degree, turn.progress), row_epsilons(degree, turn.colour_epsilon)});
}

void Trainer::descend(const Turn& turn, Pass& pass, const FrameTimes& frame) {
  differentiate(turn, pass, turn.set.error);
  const Buffer<std::uint32_t>& keys = pass.buffers().projected.keys;
  take_step(turn, turn.set.grads, keys);
  structure_.jitter(turn.set, turn.number, turn.rates, keys, status_.iteration, turn.progress);
  step_actors(turn, pass, frame);
}

bool Trainer::prunes(int iteration) const {
  const PruneOptions& o = options_.prune;
  if (!(o.weight > 0.0) || iteration < o.first) return false;
  if (sweeps_.empty() || lidar_.particles.count == 0) return false;
  for (int k = 1; k <= o.times; ++k) {
    if (iteration == static_cast<int>(o.last_share * options_.iterations * k / o.times)) return true;
  }
  return false;
}

void Trainer::look_over_sweeps() {
  Buffer<std::uint32_t> largest(device_, "largest weights", lidar_.particles.count);
  largest.fill(0);
  std::map<std::string, RowOffsets> offsets;
  if (options_.prune.row_ranges) {
    for (const LogLidar& lidar : log_.lidars) {
      const auto* const rows = std::get_if<Lidar>(&lidar.model);
      if (rows != nullptr) offsets.emplace(rows->name, RowOffsets(rows->rows.size()));
    }
  }
  for (const std::size_t index : sweeps_.frames()) {
    const SweepFrame& frame = log_.sweeps[index];
    Pass pass =
        renderer_.render(lidar_.particles, truth_.sweep(index)->truth.rays(), view_of(log_, scene_, frame));
    pass.raise_largest_weights(largest);
    const auto row = offsets.find(frame.lidar);
    if (row != offsets.end()) row->second.add(truth_.stated(index), pass.results());
  }
  for (const auto& [name, found] : offsets) {
    std::vector<double> biases_m = found.offsets();
    // Sweeps are read again for what has changed alone.
    if (std::all_of(biases_m.begin(), biases_m.end(), [](double b) { return b == 0.0; })) continue;
    const std::vector<LidarRow>& rows = std::get<Lidar>(truth_.lidar(name)).rows;
    for (std::size_t row = 0; row < rows.size(); ++row) biases_m[row] += rows[row].range_bias;
    truth_.set_range_biases(name, biases_m);
  }
  const std::vector<std::uint32_t> bits = largest.download();
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const auto weight = static_cast<double>(std::bit_cast<float>(bits[i]));
    if (weight >= options_.prune.weight) kept.push_back(static_cast<Eigen::Index>(i));
  }
  pruned_ += lidar_.particles.count - kept.size();
  lidar_.keep(kept);
}

void Trainer::step_actors(const Turn& turn, Pass& pass, const FrameTimes& frame) {
  TrainedSet& set = turn.set;
  if (set.particles.actors == 0) return;
  renderer_.confine(set.particles, scene_.actors, options_.actor_margin_m);
  if (set.poses.learns()) {
    set.poses.step(
        scene_.actors, pass.pose_gradients(set.particles), frame.start_s, frame.end_s, turn.progress);
  }
  if (set.shapes.learns()) {
    set.shapes.step(scene_.actors, pass.deformation_gradients(), frame.start_s, frame.end_s, turn.progress);
  }
}

}  // namespace simuli
