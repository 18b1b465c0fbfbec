#include "optim/train/memory.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <unistd.h>

#include "cl/shared/layout.h"
#include "host/core/base/error.hpp"
#include "host/device/render/backward/backward_stages.hpp"
#include "host/device/render/rays/ray_mask.hpp"
#include "host/device/render/scene/renderer.hpp"
#include "host/device/render/train/adam.hpp"
#include "host/device/render/train/densify.hpp"
#include "host/device/render/train/loss_stages.hpp"
#include "host/device/render/train/shard_sum.hpp"
#include "optim/base/frames.hpp"
#include "optim/train/paper/anchors.hpp"
#include "optim/train/structure.hpp"
#include "optim/train/trained_appearance.hpp"
#include "optim/train/trained_set.hpp"

namespace simuli {
namespace {

double giga(std::uint64_t bytes) { return static_cast<double>(bytes) * 1e-9; }

/// Upper bound of the slots of `rays` rays: border tiles are not full, and tiles of a sparse sweep even less.
std::uint64_t slots_of(std::uint64_t rays) { return rays + rays / 2 + SIM_TILE_RAYS; }

/// Sums the sizes of buffer tables by purpose and by buffer name.
class Tally {
 public:
  explicit Tally(MemoryNeed& need) : need_(need) {}

  template <class Sizes>
  void add(const char* item, const BufferTable<Sizes>& table, const Sizes& sizes, std::uint64_t times = 1) {
    for (const BufferBytes& buffer : table.bytes(sizes)) add(item, buffer, times);
  }
  void add(const char* item, const BufferBytes& buffer, std::uint64_t times = 1) {
    const auto found = std::find_if(
        need_.items.begin(), need_.items.end(), [&](const MemoryItem& i) { return i.name == item; });
    MemoryItem& sum = found != need_.items.end() ? *found : need_.items.emplace_back(MemoryItem{item});
    sum.bytes += times * buffer.bytes;
    need_.by_buffer[buffer.name] += times * buffer.bytes;
    need_.total += times * buffer.bytes;
    need_.largest_buffer = std::max(need_.largest_buffer, buffer.bytes);
  }

 private:
  MemoryNeed& need_;
};

/// Buffers that all stages share between frames of any size: sorts and scans for binning, anchors and
/// relocation.
constexpr std::uint64_t kSorts = 2, kScans = 4;

struct Rays {
  std::uint64_t largest = 0;  // rays of the largest frame
  std::uint64_t rows = 0;     // rows of the highest picture
  std::uint64_t slots = 0;    // slots of all frames
  std::uint64_t frames = 0;
};

Rays image_rays(const Log& log, const FrameSelection& frames) {
  Rays rays;
  for (const std::size_t index : HeldOutRule(log, frames).training(log.images)) {
    const Camera camera = scaled_camera(log.camera(log.images[index].camera).model, frames.image_scale);
    const auto pixels = static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
    rays.largest = std::max(rays.largest, pixels);
    rays.rows = std::max(rays.rows, static_cast<std::uint64_t>(camera.height));
    rays.slots += slots_of(pixels);
    ++rays.frames;
  }
  return rays;
}

Rays sweep_rays(const Log& log, const FrameSelection& frames) {
  Rays rays;
  for (const std::size_t index : HeldOutRule(log, frames).training(log.sweeps)) {
    const auto beams = static_cast<std::uint64_t>(ray_count(log.lidar(log.sweeps[index].lidar).model));
    rays.largest = std::max(rays.largest, beams);
    rays.slots += slots_of(beams);
    ++rays.frames;
  }
  return rays;
}

/// Upper bound of the particles of a set after growth; `epoch` as in epoch_of().
std::uint64_t grown(SetNumber number,
                    Eigen::Index particles,
                    Eigen::Index other,
                    std::size_t epoch,
                    const TrainOptions& options) {
  const DensifyOptions& d = options.densify;
  const auto count = static_cast<double>(particles);
  if (!(d.epochs > 0.0) || (number == kLidarSet && !d.lidar)) return static_cast<std::uint64_t>(particles);
  const int iterations = options.length.automatic ? options.length.most : options.iterations;
  const double times =
      std::floor(DensifyOptions::kLastShare * iterations / Structure::densify_every(d, epoch));
  const double by_growth = count * std::pow(1.0 + d.growth, times);
  const double by_cap =
      std::max(1.0, static_cast<double>(d.cap) / std::max(count + static_cast<double>(other), 1.0)) * count;
  return static_cast<std::uint64_t>(std::min({by_growth, by_cap, d.most * count}));
}

}  // namespace

std::string MemoryNeed::text() const {
  std::string out = fmt::format("{:.3f} GB", giga(total));
  for (std::size_t i = 0; i < items.size(); ++i) {
    out += fmt::format("{} {} {:.3f} GB", i == 0 ? ":" : ",", items[i].name, giga(items[i].bytes));
  }
  return out;
}

namespace {

struct Counts {
  std::uint64_t camera = 0, lidar = 0;  // particles
  std::uint64_t actors = 0;
  Rays images, sweeps;
  [[nodiscard]] std::uint64_t most() const { return std::max(camera, lidar); }
  [[nodiscard]] std::uint64_t slots() const { return slots_of(std::max(images.largest, sweeps.largest)); }
};

void add_set(const Device& device,
             Tally& tally,
             const char* item,
             const GaussianSet& set,
             std::uint64_t particles,
             const Counts& counts,
             const TrainOptions& options) {
  const ParticleSizes sizes = ParticleSizes::of(particles, set.sh_degree, counts.actors);
  const std::uint64_t matrix = sizes.rows * sizes.stride;
  tally.add(item, ParticleBuffers(device, GaussianSet(set.kind, 0, 0), Precision::kFloat), sizes);
  tally.add(item, AdamBuffers(device), {matrix, sizes.rows});
  tally.add(item, {"gradients", matrix * sizeof(float)});
  tally.add(item, {"reconstruction errors", particles * sizeof(float)});
  if (options.prune.weight > 0.0 && set.kind == SetKind::kLidar) {
    tally.add(item, {"largest weights", particles * sizeof(std::uint32_t)});
  }
  // A growing matrix exists twice while it is copied.
  if (options.densify.epochs > 0.0) tally.add(item, {"params", matrix * sizeof(float)});
}

void add_frame(
    const Device& device, Tally& tally, const Counts& counts, const TrainOptions& options, bool has_grids) {
  const std::uint64_t most = counts.most(), slots = counts.slots();
  constexpr std::uint64_t kSmallestTile = 32;  // slots of the smallest LiDAR tile
  const FrameSizes sizes{.particles = most,
                         .stride = round_up(most, 16),
                         .actors = counts.actors,
                         .moving_particles = counts.actors > 0 ? most : 0,
                         .visible = most,
                         .pairs = most,
                         .slots = slots,
                         .tiles = slots / kSmallestTile,
                         .ray_rows = counts.actors > 0 ? 7U : 6U,
                         .work_items = chunks_of(device, most).work_items};
  tally.add("frame", Projected(device), sizes);
  tally.add("frame", Binned(device), sizes);
  tally.add("frame", BinScratch(device), sizes);
  const SortSizes sort = SortStage::sizes(device, most);
  tally.add("frame", SortBuffers(device), sort, kSorts);
  tally.add("frame", ScanBuffers(device), ScanStage::sizes(device, std::max(most, sort.counters)), kScans);
  tally.add("frame", SampleBuffers(device), {SIM_MONTE_CARLO});
  tally.add("rays", FrameConstants(device), sizes);
  tally.add("rays", WorldRays(device), sizes);
  tally.add("rays", Blended(device), sizes);
  tally.add("rays", PictureBuffers(device), has_grids ? sizes : FrameSizes{});
  tally.add("frame", GradientBuffers(device), {.frame = sizes, .errors = options.densify.epochs > 0.0});
  tally.add("frame", ActorBuffers(device), {counts.actors});
  tally.add("rays", ImageLossBuffers(device), {sizes.tiles});
  tally.add("rays", LidarLossBuffers(device), {sizes.tiles});
}

void add_ssim(const Device& device, Tally& tally, const Counts& counts) {
  // A square picture with as many pixels has about the widest margins.
  const auto side = static_cast<std::uint32_t>(
      std::ceil(std::sqrt(static_cast<double>(slots_of(counts.images.largest)) / SIM_TILE_RAYS)));
  tally.add("SSIM", SsimBuffers(device), SsimStage::sizes(side, side, 1));
}

void add_environment(const Device& device, Tally& tally, const EnvironmentMap& map, const Counts& counts) {
  const auto texels = static_cast<std::uint64_t>(map.width) * static_cast<std::uint64_t>(map.height);
  const EnvironmentSizes sizes{texels};
  const EnvironmentBuffers texture(device);
  const std::uint64_t slots = slots_of(counts.images.largest);
  tally.add("environment", texture, sizes);
  tally.add("environment", {"environment gradients", texture.bytes(sizes).front().bytes});
  tally.add("environment", AdamBuffers(device), {4 * texels, 1});
  tally.add("environment", EnvironmentScratch(device), {slots, texels + 1});
  const SortSizes sort = SortStage::sizes(device, slots);
  tally.add("environment", SortBuffers(device), sort);
  tally.add("environment", ScanBuffers(device), ScanStage::sizes(device, sort.counters));
}

/// One optimiser updates all grids; gradients exist for one grid at a time.
void add_color_grids(const Device& device, Tally& tally, const Counts& counts, const GridPlan& plan) {
  const auto [x, y, z] = GridPlan::kSize;
  const auto vertices = static_cast<std::uint64_t>(x) * static_cast<std::uint64_t>(y * z);
  const ColorGridBuffers grids(device);
  const ColorGridSizes all{plan.images.size(), vertices};
  tally.add("colour grids", grids, all);
  tally.add("colour grids", {"colour grid gradients", grids.bytes({1, vertices}).front().bytes});
  tally.add("colour grids",
            AdamBuffers(device),
            {plan.images.size() * vertices * ColorGridBuffers::kVertexReals, 1});
  const auto partials = static_cast<std::uint64_t>((x - 1) * 2 * z) * ColorGridBuffers::kVertexReals;
  tally.add("colour grids", ColorGridScratch(device), {counts.images.rows, partials});
}

void add_rays(const Device& device, Tally& tally, const Counts& counts, const Log& log, std::uint64_t cache) {
  const RayLayout layout(device);
  const RequestedRays requested(device);
  const RaySizes of_picture{.slots = slots_of(counts.images.largest), .tile_rows = 1024};
  tally.add("rays", layout, of_picture, log.cameras.size());
  tally.add("rays", requested, of_picture, log.cameras.size());
  // Ground truth of as many frames as fit the cache; sweeps also have rays of their own.
  const std::uint64_t channels = counts.sweeps.frames > 0 ? 4 : 3;  // LiDARs mark sky pixels
  tally.add("frames kept",
            {"picture truth", std::min(cache, counts.images.slots * channels * sizeof(float))});
  if (counts.sweeps.frames == 0) return;
  tally.add("frames kept", {"sweep truth", std::min(cache, counts.sweeps.slots * 2 * sizeof(float))});
  constexpr std::uint64_t kBins = 4096;
  const RayMaskSize mask;
  const RaySizes sizes{.slots = counts.sweeps.slots / counts.sweeps.frames,
                       .tile_rows = kBins,
                       .rows = kBins,
                       .lut_bins = kBins,
                       .bins = kBins,
                       .mask_corners = static_cast<std::uint64_t>(mask.rows + 1) *
                                       static_cast<std::uint64_t>(mask.columns + 1)};
  std::uint64_t bytes = 0;
  for (const BufferBytes& buffer : layout.bytes(sizes)) bytes += buffer.bytes;
  for (const BufferBytes& buffer : requested.bytes(sizes)) bytes += buffer.bytes;
  const std::uint64_t kept = std::min(counts.sweeps.frames, cache / bytes + 1);
  tally.add("frames kept", layout, sizes, kept);
  tally.add("frames kept", requested, sizes, kept);
}

/// Buffers of off-trajectory pictures.
void add_off_trajectory(Tally& tally, const Counts& counts, std::uint64_t cameras) {
  const std::uint64_t slots = slots_of(counts.images.largest);
  tally.add("off-trajectory views", {"sensor of a recorded view", sizeof(shared::SensorConstants<float>)});
  tally.add("off-trajectory views",
            {"surfaces of a recorded view", SIM_OUTPUTS * counts.slots() * sizeof(float)});
  tally.add("off-trajectory views", {"off-trajectory picture", 3 * slots * sizeof(float)}, cameras);
  tally.add("off-trajectory views", {"ray_of_slot", slots * sizeof(std::int32_t)}, cameras);
  tally.add("off-trajectory views", {"slots_of_map", slots * sizeof(std::int32_t)}, cameras);
}

void add_structure(const Device& device, Tally& tally, const Counts& counts, const TrainOptions& options) {
  for (const BufferBytes& buffer : anchor_bytes(device, options, counts.camera, counts.lidar))
    tally.add("anchors", buffer);
  if (options.densify.epochs > 0.0) {
    const std::uint64_t most = counts.most();
    tally.add("relocation", DensifyBuffers(device), {most, most, chunks_of(device, most).work_items});
  }
}

/// Sums over the shards of a step.
void add_shards(
    const Device& device, Tally& tally, const Counts& counts, const Scene& scene, std::size_t shards) {
  // The set with the larger parameter matrix.
  const ParticleSizes camera = ParticleSizes::of(counts.camera, scene.camera.sh_degree, 0);
  const ParticleSizes lidar = ParticleSizes::of(counts.lidar, scene.lidar.sh_degree, 0);
  const ParticleSizes& set = camera.rows * camera.stride > lidar.rows * lidar.stride ? camera : lidar;
  const ShardSizes sizes{counts.most(), set.stride, set.rows + 1, true};
  tally.add("shards", ShardBuffers(device), sizes);
  tally.add("shards", ShardNodeBuffers(device), sizes, ShardSum::most_nodes(shards));
}

}  // namespace

MemoryNeed training_memory(const Device& device,
                           const Log& log,
                           const Scene& scene,
                           const TrainingOptions& training) {
  const TrainOptions& options = training.train;
  MemoryNeed need;
  Tally tally(need);
  const Rays images = image_rays(log, training.frames), sweeps = sweep_rays(log, training.frames);
  const std::size_t epoch = epoch_of(options, images.frames, sweeps.frames);
  const Counts counts{grown(kCameraSet, scene.camera.size(), scene.lidar.size(), epoch, options),
                      grown(kLidarSet, scene.lidar.size(), scene.camera.size(), epoch, options),
                      scene.actors.size(),
                      images,
                      sweeps};
  add_set(device, tally, "camera set", scene.camera, counts.camera, counts, options);
  add_set(device, tally, "LiDAR set", scene.lidar, counts.lidar, counts, options);
  const GridPlan grids =
      plan_grids(options.appearance, log, HeldOutRule(log, training.frames).training(log.images));
  add_frame(device, tally, counts, options, !grids.images.empty());
  if (options.image.dissimilarity > 0.0) add_ssim(device, tally, counts);
  if (!scene.environment.empty()) add_environment(device, tally, scene.environment, counts);
  if (!grids.images.empty()) add_color_grids(device, tally, counts, grids);
  add_rays(device, tally, counts, log, options.cache_bytes);
  if (options.off_trajectory.weight > 0.0 && counts.images.frames > 0 && counts.camera > 0 &&
      counts.lidar > 0)
    add_off_trajectory(tally, counts, log.cameras.size());
  add_structure(device, tally, counts, options);
  if (options.shards.count > 1) {
    add_shards(device, tally, counts, scene, static_cast<std::size_t>(options.shards.count));
  }
  std::sort(need.items.begin(), need.items.end(), [](const MemoryItem& a, const MemoryItem& b) {
    return a.bytes > b.bytes;
  });
  return need;
}

std::size_t frame_budget(const TrainingOptions& options) {
  std::size_t budget = options.train.host_cache_bytes;
  const std::size_t limit = options.chunks.host_memory_bytes;
  if (limit > 0) budget = std::min(budget, limit / 8);
  const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGE_SIZE);
  if (pages <= 0 || page_bytes <= 0) return budget;
  return std::min(budget, static_cast<std::size_t>(pages) * static_cast<std::size_t>(page_bytes) / 4);
}

std::uint64_t frame_bytes(const Log& log, const FrameSelection& frames) {
  constexpr std::uint64_t kOfPixel = 3 * sizeof(float), kOfRay = 5 * sizeof(float);
  std::uint64_t bytes = 0;
  for (const ImageFrame& frame : log.images) {
    const Camera camera = scaled_camera(log.camera(frame.camera).model, frames.image_scale);
    bytes += kOfPixel * static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
  }
  for (const SweepFrame& frame : log.sweeps) bytes += kOfRay * ray_count(log.lidar(frame.lidar).model);
  return bytes;
}

void need_memory(const Device& device, const Log& log, const Scene& scene, const TrainingOptions& options) {
  const MemoryNeed need = training_memory(device, log, scene, options);
  const DeviceInfo& info = device.info();
  const std::size_t limit = options.train.memory_bytes;
  const std::uint64_t allowed = limit > 0 ? limit : info.global_bytes;
  if (need.total > allowed) {
    throw Error(ErrorKind::kDevice,
                fmt::format("train: device memory: found a need of {}; allowed {:.3f} GB{} (fewer particles: "
                            "init.max_camera, init.max_lidar, densify.cap; fewer frames kept: cache_bytes; a "
                            "part of the drive at a time: chunk.length_m)",
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
