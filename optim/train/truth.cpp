#include "optim/train/truth.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/log/camera_mask.hpp"
#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/posed_frames.hpp"

namespace simuli {
namespace {

std::size_t bytes_of(const RealBuffer& buffer) {
  return buffer.count() * (buffer.precision() == Precision::kFloat ? sizeof(float) : sizeof(double));
}

}  // namespace

TruthCache::TruthCache(const Device& device,
                       const Log& log,
                       const TrainingOptions& options,
                       const RenderOptions& render)
    : device_(device),
      log_(log),
      render_(render),
      image_scale_(options.frames.image_scale),
      sky_finder_(
          log, training_frames(log.sweeps, HeldOutRule(log, options.frames)), Eigen::Vector3d::Zero()),
      cache_bytes_(options.train.cache_bytes),
      images_(cache_bytes_),
      sweeps_(cache_bytes_) {
  for (const LogCamera& camera : log.cameras) {
    models_[camera.model.name] = scaled_camera(camera.model, options.frames.image_scale);
  }
  for (const LogLidar& lidar : log.lidars) lidars_[name_of(lidar.model)] = lidar.model;
}

void TruthCache::set_range_biases(const std::string& name, const std::vector<double>& biases_m) {
  std::vector<LidarRow>& rows = std::get<Lidar>(lidars_.at(name)).rows;
  for (std::size_t row = 0; row < rows.size(); ++row) rows[row].range_bias = biases_m.at(row);
  sweeps_ = LruCache<SweepTruth>(cache_bytes_);
}

Sweep TruthCache::stated(std::size_t index) const {
  const SweepFrame& frame = log_.sweeps[index];
  return read_sweep(log_, frame, lidar(frame.lidar));
}

void TruthCache::expect(const std::vector<std::size_t>& images, const std::vector<std::size_t>& sweeps) {
  if (log_.files == nullptr) return;
  std::vector<FrameFiles::Wish> wishes;
  for (std::size_t k = 0; k < std::max(images.size(), sweeps.size()); ++k) {
    if (k < images.size() && !images_.find(images[k])) {
      const ImageFrame& frame = log_.images[images[k]];
      wishes.push_back(wish_of(log_, frame, models_.at(frame.camera)));
    }
    if (k < sweeps.size() && !sweeps_.find(sweeps[k]))
      wishes.push_back(wish_of(log_, log_.sweeps[sweeps[k]]));
  }
  if (!wishes.empty()) log_.files->expect(std::move(wishes));
}

const SensorRays& TruthCache::camera_rays(const std::string& name) {
  auto& entry = camera_rays_[name];
  if (!entry) entry = std::make_unique<SensorRays>(device_, models_.at(name), render_);
  return *entry;
}

ImageTruth TruthCache::read_image_truth(std::size_t index) {
  const ImageFrame& frame = log_.images[index];
  const SensorRays& rays = camera_rays(frame.camera);
  const auto [image, view] = load_view(log_, frame, Eigen::Vector3d::Zero(), image_scale_);
  std::vector<float> values = planar(image);
  const std::size_t pixels = values.size() / 3;
  auto& sky = sky_[index];
  if (!sky) sky = sky_finder_.find(frame, image, view);
  std::size_t known = rays.grid().rays;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (!(values[i] < 0.0F)) continue;
    for (std::size_t c = 0; c < 3; ++c) values[c * pixels + i] = kHiddenValue;
    --known;
  }
  const std::size_t channels = sky->empty() ? 3 : 4;
  for (std::size_t i = 0; i < pixels && channels == 4; ++i) values.push_back(sky->at(i) ? 1.0F : 0.0F);
  return {RayValues(rays, values, channels, "picture truth"), known};
}

SweepTruth TruthCache::read_sweep_truth(std::size_t index) const {
  const SweepFrame& frame = log_.sweeps[index];
  const Sweep sweep = stated(index);
  std::vector<float> values = sweep.range;
  std::size_t known = 0, returned = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    known += values[i] >= 0.0F ? 1U : 0U;
    returned += values[i] > 0.0F ? 1U : 0U;
  }
  values.insert(values.end(), sweep.intensity.begin(), sweep.intensity.end());
  const SensorRays rays(device_, lidar(frame.lidar), sweep.rays, render_);
  return {RayValues(rays, values, 2, "sweep truth"), known, returned};
}

std::shared_ptr<const ImageTruth> TruthCache::image(std::size_t index) {
  return images_.get(
      index,
      [&] { return read_image_truth(index); },
      [](const ImageTruth& t) { return bytes_of(t.truth.slots()); });
}

std::shared_ptr<const SweepTruth> TruthCache::sweep(std::size_t index) {
  return sweeps_.get(
      index,
      [&] { return read_sweep_truth(index); },
      [](const SweepTruth& t) {
        // The host keeps a copy of the ray grid.
        return bytes_of(t.truth.slots()) + 2 * bytes_of(t.truth.rays().buffers().requested.sensor_ray);
      });
}

}  // namespace simuli
