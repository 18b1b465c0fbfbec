#include "optim/trainer.hpp"

#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "optim/frames.hpp"

namespace simuli {
namespace {

constexpr float kUnknown = -1.0F;         // truth that the losses leave out
constexpr double kFarthestSweep_s = 0.1;  // in which a car drives a car's length at most
constexpr double kMovingReach_m = 0.5;    // from a return to the rest of the body around it

enum Stream : std::uint64_t { kImageStream = 1, kSweepStream = 2 };

RenderOptions training_options(RenderOptions options) {
  options.median_distance = false;  // has no gradient
  return options;
}

void check(const TrainOptions& o) {
  const auto need = [](bool holds, const char* field, double found, const char* allowed) {
    if (holds) return;
    throw Error(ErrorKind::kUsage, fmt::format("train: {}: found {}, allowed {}", field, found, allowed));
  };
  need(o.iterations >= 0, "iterations", o.iterations, "0 or more");
  need(o.lidar_every >= 1, "lidar_every", o.lidar_every, "1 or more");
  need(o.max_seconds >= 0.0, "max_seconds", o.max_seconds, "0 (no limit) or more");
  need(o.image_scale > 0.0 && o.image_scale <= 1.0, "image_scale", o.image_scale, "above 0, at most 1");
  need(o.held_out_every >= 0 && o.held_out_every != 1, "held_out_every", o.held_out_every, "0 or at least 2");
  if (o.render.precision != Precision::kFloat) {
    throw Error(ErrorKind::kUsage, "train: precision: found double, allowed float");
  }
  for (const LearningRates* r : {&o.camera, &o.lidar}) {
    need(r->mean_m > 0.0 && r->mean_final_m > 0.0 && std::isfinite(r->mean_m + r->mean_final_m),
         "mean rate",
         std::min(r->mean_m, r->mean_final_m),
         "finite and above 0");
    need(r->final_share > 0.0 && r->final_share <= 1.0, "final_share", r->final_share, "above 0, at most 1");
    for (const double rate : {r->log_scale, r->rotation, r->opacity, r->sh, r->sh_rest}) {
      need(rate >= 0.0 && std::isfinite(rate), "learning rate", rate, "finite, 0 or more");
    }
  }
  for (const double weight : {o.weights.distance, o.weights.intensity, o.weights.drop}) {
    need(weight >= 0.0 && std::isfinite(weight), "loss weight", weight, "finite, 0 or more");
  }
}

TrainOptions checked(const TrainOptions& options) {
  check(options);
  return options;
}

/// Padding behind the last particle gets no gradient from any kernel.
RealBuffer zeros_like(const char* name, const ParticleBuffers& particles, const Device& device) {
  RealBuffer buffer(device, name, particles.params.precision(), particles.params.count());
  buffer.fill(0.0);
  return buffer;
}

std::size_t bytes_of(const RealBuffer& buffer) {
  return buffer.count() * (buffer.precision() == Precision::kFloat ? sizeof(float) : sizeof(double));
}

void need_finite(double loss, const std::string& file) {
  if (std::isfinite(loss)) return;
  throw Error(ErrorKind::kNumeric, fmt::format("train: loss of {}: found {}", file, loss));
}

}  // namespace

void Trainer::RunningMean::add(double value) {
  constexpr double kKeep = 0.95;
  sum = kKeep * sum + value;
  weight = kKeep * weight + 1.0;
}

double Trainer::RunningMean::value() const {
  return weight > 0.0 ? sum / weight : std::numeric_limits<double>::quiet_NaN();
}

Trainer::Trainer(
    const Device& device, const Log& log, Scene scene, const TrainOptions& options, MovingSpace moving)
    : log_(log),
      scene_(std::move(scene)),
      moving_(options.mask_moving ? std::move(moving) : MovingSpace{}),
      options_(checked(options)),
      device_(device),
      renderer_(device, training_options(options_.render)),
      camera_(device, scene_.camera, Precision::kFloat),
      lidar_(device, scene_.lidar, Precision::kFloat),
      camera_grads_(zeros_like("camera gradients", camera_, device)),
      lidar_grads_(zeros_like("lidar gradients", lidar_, device)),
      camera_adam_(device, camera_),
      lidar_adam_(device, lidar_),
      images_(select_frames(log.images, options.held_out_every, false), options.seed, kImageStream),
      sweeps_(select_frames(log.sweeps, options.held_out_every, false), options.seed, kSweepStream),
      image_cache_(options.cache_bytes),
      sweep_cache_(options.cache_bytes) {
  if (images_.empty() && sweeps_.empty()) {
    throw_input_error(log.folder.string(), "training frames", "0", "at least one image or sweep");
  }
  for (const LogCamera& camera : log.cameras) {
    models_[camera.model.name] = scaled_camera(camera.model, options.image_scale);
  }
  status_.psnr_db = status_.distance_m = status_.drop_accuracy = std::numeric_limits<double>::quiet_NaN();
}

const SensorRays& Trainer::camera_rays(const std::string& name) {
  auto& entry = camera_rays_[name];
  if (!entry) entry = std::make_unique<SensorRays>(device_, models_.at(name), renderer_.options());
  return *entry;
}

MovingReturns Trainer::moving_returns(const SweepFrame& frame, const Sweep& sweep) const {
  const View view = view_of(log_, scene_, frame);
  return find_moving_returns(moving_,
                             sweep,
                             log_.lidar(frame.lidar).model,
                             view.world_from_sensor_start,
                             view.world_from_sensor_end);
}

/// By the training sweep nearest in time. Empty when nothing moved or no sweep is near enough to tell.
std::vector<bool> Trainer::hidden_pixels(const ImageFrame& frame) const {
  if (moving_.voxels() == 0) return {};
  const double time_s = 0.5 * (frame.time_start_s + frame.time_end_s);
  const SweepFrame* nearest = nullptr;
  double nearest_s = kFarthestSweep_s;
  for (const std::size_t index : select_frames(log_.sweeps, options_.held_out_every, false)) {
    const SweepFrame& sweep = log_.sweeps[index];
    const double apart_s = std::abs(0.5 * (sweep.time_start_s + sweep.time_end_s) - time_s);
    if (apart_s > nearest_s) continue;
    nearest_s = apart_s;
    nearest = &sweep;
  }
  if (nearest == nullptr) return {};
  const Sweep sweep = read_sweep(log_.folder / nearest->file, log_.lidar(nearest->lidar).model);
  const View view = view_of(log_, scene_, frame);
  const ImageView image_view(
      models_.at(frame.camera), view.world_from_sensor_start, view.world_from_sensor_end);
  return moving_pixels(image_view, moving_returns(*nearest, sweep).p_scene, kMovingReach_m);
}

std::shared_ptr<const Trainer::ImageTruth> Trainer::image_truth(std::size_t index, const SensorRays& rays) {
  const ImageFrame& frame = log_.images[index];
  return image_cache_.get(
      index,
      [&] {
        ImageTruth out{RealBuffer(device_, "picture", Precision::kFloat)};
        std::vector<float> values = planar(load_image(log_, frame, models_.at(frame.camera)));
        const std::vector<bool> hidden = hidden_pixels(frame);
        out.known = rays.grid().rays;
        for (std::size_t i = 0; i < hidden.size(); ++i) {
          if (!hidden[i]) continue;
          for (std::size_t c = 0; c < 3; ++c) values[c * hidden.size() + i] = kUnknown;
          --out.known;
        }
        out.truth.assign(rays.to_slots(values, 3));
        return out;
      },
      [](const ImageTruth& t) { return bytes_of(t.truth); });
}

std::shared_ptr<const Trainer::SweepTruth> Trainer::sweep_truth(std::size_t index) {
  const SweepFrame& frame = log_.sweeps[index];
  return sweep_cache_.get(
      index,
      [&] {
        const Lidar& lidar = log_.lidar(frame.lidar).model;
        const Sweep sweep = read_sweep(log_.folder / frame.file, lidar);
        SweepTruth out{std::make_unique<SensorRays>(device_, lidar, sweep.rays, renderer_.options()),
                       RealBuffer(device_, "sweep", Precision::kFloat)};
        const MovingReturns moving = moving_returns(frame, sweep);
        std::vector<float> values = sweep.range;
        for (std::size_t i = 0; i < values.size(); ++i) {
          if (moving.is_moving[i]) values[i] = kUnknown;
          out.known += values[i] >= 0.0F ? 1U : 0U;
          out.returned += values[i] > 0.0F ? 1U : 0U;
        }
        values.insert(values.end(), sweep.intensity.begin(), sweep.intensity.end());
        out.truth.assign(out.rays->to_slots(values, 2));
        return out;
      },
      [](const SweepTruth& t) {
        // The ray grid stands on the host as well.
        return bytes_of(t.truth) + 2 * bytes_of(t.rays->buffers().sensor_ray);
      });
}

void Trainer::step_camera(double progress) {
  const std::size_t index = images_.at(static_cast<std::uint64_t>(status_.iteration));
  const ImageFrame& frame = log_.images[index];
  const SensorRays& rays = camera_rays(frame.camera);
  const auto truth = image_truth(index, rays);
  renderer_.render(camera_, rays, view_of(log_, scene_, frame));
  const double values = 3.0 * std::max(1.0, static_cast<double>(truth->known));
  const ImageLoss loss = renderer_.image_loss(truth->truth, 1.0 / values, options_.colour_squared / values);
  need_finite(loss.absolute + loss.squared, frame.file);
  renderer_.backward(camera_, camera_grads_);
  camera_adam_.run(camera_,
                   camera_grads_,
                   renderer_.buffers().keys,
                   row_rates(options_.camera, camera_.sh_degree, progress));
  square_.add(loss.squared / values);
  status_.psnr_db = -10.0 * std::log10(square_.value());
}

void Trainer::step_lidar(double progress) {
  const std::size_t index = sweeps_.at(static_cast<std::uint64_t>(status_.iteration / options_.lidar_every));
  const SweepFrame& frame = log_.sweeps[index];
  const auto truth = sweep_truth(index);
  renderer_.render(lidar_, *truth->rays, view_of(log_, scene_, frame));
  const double rays = std::max(1.0, static_cast<double>(truth->known));
  // A sweep without a return has no distance loss to weigh: its sums are zero.
  const double returned = std::max(1.0, static_cast<double>(truth->returned));
  const LidarWeights& w = options_.weights;
  const LidarLoss loss =
      renderer_.lidar_loss(truth->truth, {w.distance / returned, w.intensity / returned, w.drop / rays});
  need_finite(loss.distance_m + loss.intensity + loss.entropy, frame.file);
  renderer_.backward(lidar_, lidar_grads_);
  lidar_adam_.run(
      lidar_, lidar_grads_, renderer_.buffers().keys, row_rates(options_.lidar, lidar_.sh_degree, progress));
  distance_.add(loss.distance_m / returned);
  right_.add(1.0 - loss.wrong / rays);
  status_.distance_m = distance_.value();
  status_.drop_accuracy = right_.value();
}

void Trainer::step() {
  const double progress = static_cast<double>(status_.iteration) / std::max(1, options_.iterations);
  if (!images_.empty() && camera_.count > 0) step_camera(progress);
  const bool lidar_turn = status_.iteration % options_.lidar_every == 0;
  if (lidar_turn && !sweeps_.empty() && lidar_.count > 0) step_lidar(progress);
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
  report.rejected_gradients = camera_adam_.rejected() + lidar_adam_.rejected();
  report.seconds = elapsed_s();
  return report;
}

Scene Trainer::scene() const {
  Scene out = scene_;
  out.camera = camera_.download();
  out.lidar = lidar_.download();
  return out;
}

}  // namespace simuli
