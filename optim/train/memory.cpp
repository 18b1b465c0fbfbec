#include "optim/train/memory.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "cl/shared/layout.h"
#include "host/base/error.hpp"
#include "optim/base/frames.hpp"

namespace simuli {
namespace {

constexpr std::uint64_t kReal = sizeof(float);
constexpr std::uint64_t kWord = sizeof(std::uint32_t);

double giga(std::uint64_t bytes) { return static_cast<double>(bytes) * 1e-9; }

/// Slots that `rays` rays of a frame lie in, at most; tiles at the edges are not full, and those of a sparse
/// sweep less so.
std::uint64_t slots_of(std::uint64_t rays) { return rays + rays / 2 + SIM_TILE_RAYS; }

/// Of each sweep's own rays: beam table and bins of columns, 4096 each, and the mask of 1600 x 8 cells.
constexpr std::uint64_t kSweepTables = (2 * 4096 + 1601 * 9 + 1024) * kWord;
/// Of sorting, scanning and tiling, whatever the frame.
constexpr std::uint64_t kScratch = std::uint64_t{1} << 19U;

struct Rays {
  std::uint64_t largest = 0;  // rays of the largest frame
  std::uint64_t slots = 0;    // of all frames
  std::uint64_t frames = 0;
};

Rays image_rays(const Log& log, const FrameSelection& frames) {
  Rays rays;
  for (const std::size_t index : select_frames(log.images, frames.held_out_every, false)) {
    const Camera camera = scaled_camera(log.camera(log.images[index].camera).model, frames.image_scale);
    const auto pixels = static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
    rays.largest = std::max(rays.largest, pixels);
    rays.slots += slots_of(pixels);
    ++rays.frames;
  }
  return rays;
}

Rays sweep_rays(const Log& log, const FrameSelection& frames) {
  Rays rays;
  for (const std::size_t index : select_frames(log.sweeps, frames.held_out_every, false)) {
    const auto beams = static_cast<std::uint64_t>(ray_count(log.lidar(log.sweeps[index].lidar).model));
    rays.largest = std::max(rays.largest, beams);
    rays.slots += slots_of(beams);
    ++rays.frames;
  }
  return rays;
}

/// The particles that a set may come to have.
std::uint64_t grown(Eigen::Index particles, Eigen::Index other, const TrainOptions& options) {
  const DensifyOptions& d = options.densify;
  const auto count = static_cast<double>(particles);
  if (d.every == 0) return static_cast<std::uint64_t>(particles);
  const double times = std::floor(d.last_share * options.iterations / d.every);
  const double by_growth = count * std::pow(1.0 + d.growth, times);
  const double by_cap =
      std::max(1.0, static_cast<double>(d.cap) / std::max(count + static_cast<double>(other), 1.0)) * count;
  return static_cast<std::uint64_t>(std::min(by_growth, by_cap));
}

}  // namespace

std::string MemoryNeed::text() const {
  std::string out = fmt::format("{:.3f} GB", giga(total));
  for (std::size_t i = 0; i < items.size(); ++i) {
    out += fmt::format("{} {} {:.3f} GB", i == 0 ? ":" : ",", items[i].name, giga(items[i].bytes));
  }
  return out;
}

MemoryNeed training_memory(const Log& log, const Scene& scene, const TrainingOptions& training) {
  const TrainOptions& options = training.train;
  MemoryNeed need;
  const auto add = [&need](const char* name, std::uint64_t bytes, std::uint64_t largest) {
    need.items.push_back({name, bytes});
    need.total += bytes;
    need.largest_buffer = std::max(need.largest_buffer, largest);
  };
  const std::uint64_t camera = grown(scene.camera.size(), scene.lidar.size(), options);
  const std::uint64_t lidar = grown(scene.lidar.size(), scene.camera.size(), options);
  const auto add_set = [&](const char* name, std::uint64_t count, const GaussianSet& set) {
    // Parameters, gradients and two moments; while one of them grows it is there twice.
    const std::uint64_t matrix = count * static_cast<std::uint64_t>(param_rows(set.sh_degree)) * kReal;
    add(name, (options.densify.every > 0 ? 5 : 4) * matrix + count * kReal, matrix);
  };
  add_set("camera set", camera, scene.camera);
  add_set("LiDAR set", lidar, scene.lidar);

  const std::uint64_t most = std::max(camera, lidar);
  const std::uint64_t instances = most;
  // Records, footprints, keys, emission, order and its keys; tile, payload and two for sorting; gradient
  // slots.
  add("frame",
      kScratch + most * (SIM_RECORD * kReal + sizeof(shared::Footprint) + 4 * kWord) +
          instances * (4 * kWord + (SIM_GRAD + 1) * kReal),
      std::max(most, instances) * SIM_GRAD * kReal);

  const Rays images = image_rays(log, training.frames);
  const Rays sweeps = sweep_rays(log, training.frames);
  // World rays, outputs, their gradients and errors, and the gradients by ray; sensor rays of each camera.
  const bool learns_poses = options.poses.camera || options.poses.lidar;
  const std::uint64_t per_slot = (7 + SIM_OUTPUTS + 5 + 1 + (learns_poses ? 6 : 0)) * kReal;
  const std::uint64_t sensor_ray = 8 * kReal;
  add("rays",
      slots_of(std::max(images.largest, sweeps.largest)) * per_slot +
          slots_of(images.largest) * sensor_ray * log.cameras.size(),
      slots_of(std::max(images.largest, sweeps.largest)) * SIM_OUTPUTS * kReal);
  // Planes, moments and slopes of SSIM, by pixel.
  constexpr std::uint64_t kSsimPlanes = 15;
  if (options.image.dissimilarity > 0.0) {
    add("SSIM", slots_of(images.largest) * kSsimPlanes * kReal, slots_of(images.largest) * 6 * kReal);
  }
  const std::uint64_t cache = options.cache_bytes;
  add("frames kept",
      std::min(cache, images.slots * 3 * kReal) +
          std::min(cache, sweeps.slots * (2 * kReal + sensor_ray) + sweeps.frames * kSweepTables),
      slots_of(std::max(images.largest, sweeps.largest)) * 7 * kReal);
  if (options.anchor.weight > 0.0 && camera > 0 && lidar > 0) {
    const std::uint64_t candidates = camera * static_cast<std::uint64_t>(options.anchor.neighbours) * kWord;
    // The tree: order and keys with their doubles, points, numbers, boxes.
    add("anchors", candidates + camera * kWord + lidar * (5 * kWord + 3 * kReal + kReal), candidates);
  }
  // Of each particle: dead or not, its share, target, source and copies.
  if (options.densify.every > 0) add("relocation", 6 * most * kWord, most * kWord);
  std::sort(need.items.begin(), need.items.end(), [](const MemoryItem& a, const MemoryItem& b) {
    return a.bytes > b.bytes;
  });
  return need;
}

void need_memory(const Device& device, const Log& log, const Scene& scene, const TrainingOptions& options) {
  const MemoryNeed need = training_memory(log, scene, options);
  const DeviceInfo& info = device.info();
  const std::size_t limit = options.train.memory_bytes;
  const std::uint64_t allowed = limit > 0 ? limit : info.global_bytes;
  if (need.total > allowed) {
    throw Error(ErrorKind::kDevice,
                fmt::format("train: device memory: found a need of {}; allowed {:.3f} GB{} (fewer particles: "
                            "init.max_camera, init.max_lidar, densify.cap; fewer frames kept: cache_bytes)",
                            need.text(),
                            giga(allowed),
                            limit > 0 ? " by memory_bytes" : " of " + info.label()));
  }
  if (need.largest_buffer > info.max_alloc_bytes) {
    throw Error(ErrorKind::kDevice,
                fmt::format("train: largest buffer: found {:.3f} GB, allowed {:.3f} GB by {}",
                            giga(need.largest_buffer),
                            giga(info.max_alloc_bytes),
                            info.label()));
  }
}

}  // namespace simuli
