#include "bench/paper/unified.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/device/render/train/adam.hpp"
#include "optim/base/frames.hpp"
#include "optim/train/schedule.hpp"
#include "optim/train/trained_appearance.hpp"
#include "optim/train/truth.hpp"

namespace simuli::bench {
namespace {

constexpr double kIntensityWeight = 0.1, kDropWeight = 0.05;
// Initial LiDAR features: medium reflectance, and a return more likely than none.
constexpr float kHit = 2.0F;

/// Returns a LiDAR set with the geometry of the camera set.
GaussianSet lidar_twin(const GaussianSet& camera, int sh_degree) {
  GaussianSet set(SetKind::kLidar, sh_degree, camera.size());
  set.params.leftCols(kShRow) = camera.params.leftCols(kShRow);
  set.sh(0).col(1).setConstant(kHit / kSh0);
  set.sh(0).col(2).setConstant(-kHit / kSh0);
  return set;
}

Scene with_twin(Scene scene) {
  scene.lidar = lidar_twin(scene.camera, scene.lidar.sh_degree);
  return scene;
}

RenderOptions without_median(RenderOptions options) {
  options.median_distance = false;  // has no gradient
  return options;
}

/// The set of one sensor and its optimiser state.
struct SensorSide {
  SensorSide(const Device& device, const GaussianSet& set)
      : particles(device, set, Precision::kFloat),
        grads(device, "gradients", Precision::kFloat, particles.params.count()),
        adam(device, particles) {}
  ParticleBuffers particles;
  RealBuffer grads;
  AdamStage adam;
};

class UnifiedTrainer {
 public:
  UnifiedTrainer(const Device& device,
                 const Log& log,
                 Scene start,
                 const TrainingOptions& options,
                 double distance_weight)
      : log_(log),
        scene_(with_twin(std::move(start))),
        options_(checked(options).train),
        sweep_every_(iterations_a_sweep(options, log)),
        distance_weight_(distance_weight),
        renderer_(device, without_median(options.train.render)),
        truth_(device, log, options, renderer_.options()),
        camera_(device, scene_.camera),
        lidar_(device, scene_.lidar),
        look_(device, log, scene_, options),
        keys_(device, "keys of both", scene_.camera.size()),
        images_(HeldOutRule(log, options.frames).training(log.images), options.frames.seed, 1),
        sweeps_(HeldOutRule(log, options.frames).training(log.sweeps), options.frames.seed, 2) {}

  void step(int iteration) {
    const double progress = static_cast<double>(iteration) / options_.iterations;
    const auto index = static_cast<std::uint64_t>(iteration);
    const Pass picture = camera_gradients(images_.at(index), index);
    std::vector<std::uint32_t> keys = picture.buffers().projected.keys.download();
    std::vector<float> grads = camera_.grads.download_float();
    const std::size_t stride = camera_.particles.stride;
    if (iteration % sweep_every_ == 0) {
      const Pass sweep = lidar_gradients(sweeps_.at(static_cast<std::uint64_t>(iteration / sweep_every_)));
      const std::vector<std::uint32_t> seen = sweep.buffers().projected.keys.download();
      const std::vector<float> more = lidar_.grads.download_float();
      for (std::size_t row = 0; row < kShRow; ++row) {
        for (std::size_t i = 0; i < seen.size(); ++i) grads[row * stride + i] += more[row * stride + i];
      }
      for (std::size_t i = 0; i < seen.size(); ++i) keys[i] = std::min(keys[i], seen[i]);
      // Only the LiDAR's features; the geometry is updated once, below.
      std::vector<double> rates = row_rates(options_.lidar, lidar_.particles.sh_degree, progress);
      std::fill(rates.begin(), rates.begin() + kShRow, 0.0);
      lidar_.adam.run(lidar_.particles, lidar_.grads, sweep.buffers().projected.keys, {rates});
    }
    keys_.upload(std::span<const std::uint32_t>(keys));
    camera_.grads.upload(std::span<const float>(grads));
    camera_.adam.run(
        camera_.particles,
        camera_.grads,
        keys_,
        {row_rates(paced(options_.camera, options_.iterations), camera_.particles.sh_degree, progress),
         row_epsilons(camera_.particles.sh_degree, look_.harmonics_epsilon(camera_.particles.count))});
    const std::vector<float> params = camera_.particles.params.download_float();
    lidar_.particles.params.as_float().upload_at(0, std::span<const float>(params).first(kShRow * stride));
  }

  [[nodiscard]] Scene scene() const {
    Scene out = scene_;
    out.camera = camera_.particles.download();
    out.lidar = lidar_.particles.download();
    look_.store(out);
    return out;
  }

 private:
  Pass camera_gradients(std::size_t index, std::uint64_t iteration) {
    const ImageFrame& frame = log_.images[index];
    const auto truth = truth_.image(index);
    Pass pass = renderer_.render(camera_.particles,
                                 truth_.camera_rays(frame.camera),
                                 view_of(log_, scene_, frame),
                                 look_.environment());
    look_.grade(pass, index);
    const double values = 3.0 * std::max(1.0, static_cast<double>(truth->known));
    const ImageWeights& w = options_.image;
    (void)pass.image_loss(truth->truth, {w.absolute / values, w.squared / values, w.dissimilarity / values});
    look_.backward(pass, index);
    look_.step({{index, {}}}, iteration, options_.iterations, nullptr);
    pass.backward(camera_.particles, camera_.grads);
    return pass;
  }
  Pass lidar_gradients(std::size_t index) {
    const auto truth = truth_.sweep(index);
    Pass pass =
        renderer_.render(lidar_.particles, truth->truth.rays(), view_of(log_, scene_, log_.sweeps[index]));
    const double rays = std::max(1.0, static_cast<double>(truth->known));
    const double returned = std::max(1.0, static_cast<double>(truth->returned));
    (void)pass.lidar_loss(truth->truth,
                          {distance_weight_ / returned, kIntensityWeight / returned, kDropWeight / rays});
    pass.backward(lidar_.particles, lidar_.grads);
    return pass;
  }

  const Log& log_;
  Scene scene_;
  TrainOptions options_;
  int sweep_every_;
  double distance_weight_;
  Renderer renderer_;
  TruthCache truth_;
  SensorSide camera_, lidar_;
  TrainedAppearance look_;
  Buffer<std::uint32_t> keys_;
  FrameOrder images_, sweeps_;
};

}  // namespace

Scene fit_unified(const Device& device,
                  const Log& log,
                  Scene start,
                  const TrainingOptions& options,
                  double distance_weight) {
  UnifiedTrainer trainer(device, log, std::move(start), options, distance_weight);
  for (int i = 0; i < options.train.iterations; ++i) trainer.step(i);
  return trainer.scene();
}

}  // namespace simuli::bench
