#include "host/render/scene/tile_tuning.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <tuple>

#include "host/base/stopwatch.hpp"
#include "host/render/scene/renderer.hpp"
#include "host/scene/particle_street.hpp"

namespace simuli {
namespace {

constexpr int kElevationTiles[] = {1, 2, 4, 8, 16, 32, 64};
constexpr int kRays[] = {32, 64, 128, 256};
constexpr int kBriefFrames = 3;
constexpr std::size_t kFinalists = 4;

RenderOptions options_with(const TileChoice& tiles) {
  RenderOptions options;
  options.lidar_tiles = tiles;
  return options;
}

/// One sensor before the street, at rest, with one way to render it.
class LidarTimer {
 public:
  LidarTimer(const Device& device,
             const LidarModel& sensor,
             const ParticleBuffers& particles,
             const RenderOptions& options)
      : particles_(particles),
        renderer_(device, options),
        rays_(device, sensor, nominal_rays(sensor), options),
        view_{world_from_street_lidar(), world_from_street_lidar(), {0.0F, 0.0F, 0.0F}} {}

  /// From the call to the result on the device.
  double frame_ms() {
    return time_ms([&] {
      pass_ = renderer_.render(particles_, rays_, view_);
      renderer_.device().finish();
    });
  }
  /// The last frame.
  [[nodiscard]] const Pass& pass() const { return *pass_; }

 private:
  const ParticleBuffers& particles_;
  Renderer renderer_;
  std::optional<Pass> pass_;
  SensorRays rays_;
  View view_;
};

TileTime tiles_of(const TileChoice& tiles, const LidarTimer& frames) {
  const auto& frame = frames.pass().frame();
  return {tiles, frame.tiles_y, frame.tiles_x, frame.tile_rays, {}};
}

/// After one frame that compiles.
Spread brief(LidarTimer& frames) {
  std::vector<double> samples;
  for (int i = -1; i < kBriefFrames; ++i) {
    const double ms = frames.frame_ms();
    if (i >= 0) samples.push_back(ms);
  }
  return spread_of(samples);
}

}  // namespace

TileGrid time_tiles(const Device& device, const LidarModel& sensor, std::int64_t particles, int frames) {
  constexpr int kShDegree = 3;
  constexpr std::uint64_t kSeed = 1;
  const ParticleBuffers street(
      device, street_particles(SetKind::kLidar, kShDegree, particles, kSeed), Precision::kFloat);
  TileGrid grid;
  const auto shape = [](const TileTime& t) { return std::tuple(t.tile_rows, t.tile_columns, t.tile_slots); };
  for (const int elevation : kElevationTiles) {
    for (const int rays : kRays) {
      LidarTimer one(device, sensor, street, options_with({elevation, rays}));
      (void)one.frame_ms();
      TileTime time = tiles_of({elevation, rays}, one);
      const bool known = std::any_of(
          grid.times.begin(), grid.times.end(), [&](const TileTime& t) { return shape(t) == shape(time); });
      if (known) continue;
      time.frame_ms = brief(one);
      grid.times.push_back(time);
    }
  }
  std::vector<std::size_t> order(grid.times.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return grid.times[a].frame_ms.median < grid.times[b].frame_ms.median;
  });
  order.resize(std::min(order.size(), kFinalists));

  // The last one is the automatic choice.
  std::vector<std::unique_ptr<LidarTimer>> finalists;
  for (const std::size_t i : order) {
    finalists.push_back(
        std::make_unique<LidarTimer>(device, sensor, street, options_with(grid.times[i].tiles)));
  }
  finalists.push_back(std::make_unique<LidarTimer>(device, sensor, street, options_with({})));
  std::vector<std::vector<double>> samples(finalists.size());
  for (int frame = -1; frame < frames; ++frame) {
    for (std::size_t k = 0; k < finalists.size(); ++k) {
      const double ms = finalists[k]->frame_ms();
      if (frame >= 0) samples[k].push_back(ms);
    }
  }
  grid.best = order.front();
  for (std::size_t k = 0; k < order.size(); ++k) {
    grid.times[order[k]].frame_ms = spread_of(samples[k]);
    if (grid.times[order[k]].frame_ms.median < grid.times[grid.best].frame_ms.median) grid.best = order[k];
  }
  grid.automatic = tiles_of({}, *finalists.back());
  grid.automatic.frame_ms = spread_of(samples.back());
  return grid;
}

}  // namespace simuli
