// Tests binning: each (tile, particle) pair once, nearest first, and no required pair missing.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/device/render/frame/stages.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using test::SceneCase;

constexpr std::uint32_t kCulled = 0xffffffffU;

/// One pair as stored in the payload.
struct TilePair {
  std::uint32_t particle = 0, first_ray_block = 0, last_ray_block = 0;
};
TilePair unpacked(std::uint32_t payload) {
  return {
      payload & SIM_PARTICLE_MASK, payload >> SIM_PARTICLE_BITS & 15U, payload >> (SIM_PARTICLE_BITS + 4)};
}

/// Returns tile lists by (tile, particle) after general checks: `first` is monotone and complete, no pair is
/// repeated, each tile is ordered by range, then by index.
std::map<std::pair<std::uint32_t, std::uint32_t>, TilePair> checked_lists(const shared::FrameParams& frame,
                                                                          const FrameBuffers& buffers) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, TilePair> lists;
  const std::uint32_t tiles = frame.tiles_x * frame.tiles_y;
  const std::vector<std::uint32_t> first = buffers.binned.first.download();
  const std::vector<std::uint32_t> payload = buffers.binned.payload.download();
  const std::vector<std::uint32_t> keys = buffers.projected.keys.download();
  EXPECT_EQ(first.size(), tiles + 1);
  EXPECT_EQ(first.front(), 0U);
  EXPECT_EQ(first.back(), buffers.binned.pairs);
  EXPECT_TRUE(std::is_sorted(first.begin(), first.end()));
  for (std::uint32_t tile = 0; tile < tiles; ++tile) {
    std::pair<std::uint32_t, std::uint32_t> before{0, 0};
    for (std::uint32_t i = first[tile]; i < first[tile + 1]; ++i) {
      const TilePair pair = unpacked(payload[i]);
      const std::pair<std::uint32_t, std::uint32_t> place{keys[pair.particle], pair.particle};
      EXPECT_TRUE(i == first[tile] || before < place) << "tile " << tile;
      before = place;
      EXPECT_TRUE(lists.emplace(std::pair(tile, pair.particle), pair).second) << "tile " << tile;
    }
  }
  const auto visible = std::count_if(keys.begin(), keys.end(), [](std::uint32_t k) { return k != kCulled; });
  EXPECT_EQ(buffers.binned.visible, static_cast<std::uint32_t>(visible));
  return lists;
}

/// Returns a range of tile columns; for pictures from a block column of the first tile to one of the last.
std::uint32_t interval(const shared::FrameParams& frame,
                       std::uint32_t first,
                       std::uint32_t count,
                       std::uint32_t block,
                       std::uint32_t other) {
  const bool blocks = frame.row_slots == 0;
  const std::uint32_t from = !blocks ? 0 : count == 1 ? std::min(block, other) : block;
  const std::uint32_t to = !blocks ? SIM_TILE_BLOCKS - 1 : count == 1 ? std::max(block, other) : other;
  return SIM_COLUMNS(first * SIM_TILE_BLOCKS + from, (first + count - 1) * SIM_TILE_BLOCKS + to);
}

/// Creates random rectangles; a third is culled, some have a second range of tile columns.
void random_footprints(const shared::FrameParams& frame,
                       const std::vector<std::uint32_t>& tile_rows,
                       FrameBuffers& buffers,
                       std::uint64_t seed) {
  test::Random random(seed);
  std::vector<shared::Footprint> footprints(frame.particles);
  std::vector<std::uint32_t> keys(frame.particles, kCulled);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random.uniform(0.0, n)); };
  for (std::size_t i = 0; i < footprints.size(); ++i) {
    shared::Footprint& f = footprints[i];
    const std::uint32_t first = below(frame.tiles_x);
    const std::uint32_t columns =
        1 + below(i % 5 == 0 ? frame.tiles_x - first : std::min(frame.tiles_x - first, 2U));
    f.columns = interval(frame, first, columns, below(4), below(4));
    if (i % 4 == 0 && first > 1)
      f.others =
          interval(frame, 0, 1 + below(first - 1), below(4), below(4));  // before the first, apart from it
    const std::uint32_t row_first = below(frame.rows);
    const std::uint32_t row_last = row_first + below(frame.rows - row_first);
    f.rows = row_first | row_last << 16U;
    const auto tile_row = [&](std::uint32_t row) {
      return static_cast<std::uint32_t>(std::upper_bound(tile_rows.begin(), tile_rows.end(), row) -
                                        tile_rows.begin() - 1);
    };
    f.tile_rows = tile_row(row_first) | (tile_row(row_last) - tile_row(row_first) + 1) << 16U;
    if (i % 3 == 1) continue;
    const float range = static_cast<float>(std::floor(random.uniform(1.0, 40.0)) / 4.0);  // with ties
    std::memcpy(&keys[i], &range, sizeof(range));
  }
  buffers.projected.footprints.assign(std::span<const shared::Footprint>(footprints));
  buffers.projected.keys.assign(std::span<const std::uint32_t>(keys));
  // With or without omitted clusters that have no visible particle.
  std::vector<std::uint32_t> live((keys.size() + SIM_CLUSTER - 1) / SIM_CLUSTER, seed % 2);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] != kCulled) live[i / SIM_CLUSTER] = 1;
  }
  buffers.projected.live.assign(std::span<const std::uint32_t>(live));
}

class Bin : public testing::TestWithParam<std::size_t> {};

TEST_P(Bin, ListsAreThoseOfTheRectangles) {
  const Device& device = test::device();
  BinStage bin(device, GetParam());
  FrameBuffers buffers(device, Precision::kFloat);
  const ParticleBuffers all(device, GaussianSet(SetKind::kCamera, 0, 0), Precision::kFloat);
  constexpr shared::FrameParams kSweep{.particles = 0,
                                       .stride = 0,
                                       .tiles_x = 7,
                                       .tiles_y = 3,
                                       .rows = 20,
                                       .tile_rays = SIM_TILE_RAYS,
                                       .row_slots = 2,
                                       .slots = 0};
  constexpr shared::FrameParams kPicture{.particles = 0,
                                         .stride = 0,
                                         .tiles_x = 5,
                                         .tiles_y = 4,
                                         .rows = 50,
                                         .tile_rays = SIM_TILE_RAYS,
                                         .row_slots = 0,
                                         .slots = 0};
  constexpr shared::FrameParams kOneTile{.particles = 0,
                                         .stride = 0,
                                         .tiles_x = 1,
                                         .tiles_y = 1,
                                         .rows = 1,
                                         .tile_rays = SIM_TILE_RAYS,
                                         .row_slots = 1,
                                         .slots = 0};
  const std::vector<std::pair<shared::FrameParams, std::vector<std::uint32_t>>> cases{
      {kSweep, {0, 5, 13, 20}}, {kPicture, {0, 16, 32, 48, 50}}, {kOneTile, {0, 1}}};
  for (auto [frame, tile_rows] : cases) {
    RayLayout layout(device);
    const RequestedRays requested(device);
    const RayBuffers rays{layout, requested};
    layout.tile_rows.assign(tile_rows);
    for (const std::uint32_t n : {1000U, 1U, 2U, 0U, 17U, 333U}) {  // shrinking: stale content would show
      SCOPED_TRACE(std::to_string(n) + " particles, " + std::to_string(frame.tiles_x) + " tile columns");
      frame.particles = n;
      random_footprints(frame, tile_rows, buffers, n + frame.tiles_x);
      bin.run(frame, all, rays, buffers.projected, std::size_t{1} << 20U, buffers.binned);
      const auto lists = checked_lists(frame, buffers);
      const auto footprints = buffers.projected.footprints.download();
      const auto keys = buffers.projected.keys.download();
      std::size_t expected = 0;
      for (std::uint32_t particle = 0; particle < n; ++particle) {
        if (keys[particle] == kCulled) continue;
        const shared::Footprint& f = footprints[particle];
        std::uint32_t own = 0;
        for (std::uint32_t ty = 0; ty < frame.tiles_y; ++ty) {
          const std::uint32_t top = tile_rows[ty];
          const std::uint32_t bottom = tile_rows[ty + 1] - 1;
          const std::uint32_t row_first = SIM_LOW(f.rows), row_last = SIM_HIGH(f.rows);
          if (row_last < top || row_first > bottom) continue;
          const std::uint32_t columns = SIM_HIGH(f.columns), others = SIM_HIGH(f.others);
          for (std::uint32_t k = 0; k < columns + others; ++k) {
            const std::uint32_t part = k < columns ? f.columns : f.others;
            const std::uint32_t tx = SIM_TILE_COLUMN(part) + (k < columns ? k : k - columns);
            const auto found = lists.find({ty * frame.tiles_x + tx, particle});
            ASSERT_NE(found, lists.end());
            const std::uint32_t row = std::max(row_first, top) - top, last = std::min(row_last, bottom) - top;
            if (frame.row_slots > 0) {
              EXPECT_EQ(found->second.first_ray_block, row * frame.row_slots);
              EXPECT_EQ(found->second.last_ray_block, (last + 1) * frame.row_slots - 1);
            } else {  // two corners in blocks of 4 x 4 of the tile's 4 x 4
              const std::uint32_t left = std::max(SIM_FIRST_BLOCK(part), tx * 4) - tx * 4;
              const std::uint32_t right = std::min(SIM_LAST_BLOCK(part), tx * 4 + 3) - tx * 4;
              EXPECT_EQ(found->second.first_ray_block, row / 4 * 4 + left);
              EXPECT_EQ(found->second.last_ray_block, last / 4 * 4 + right);
            }
            ++own;
          }
        }
        expected += own;
      }
      EXPECT_EQ(buffers.binned.pairs, expected);
      EXPECT_EQ(lists.size(), expected);
    }
  }
}

TEST_P(Bin, FramesThatNeedTooMuchAreRefused) {
  const Device& device = test::device();
  BinStage bin(device, GetParam());
  FrameBuffers buffers(device, Precision::kFloat);
  const ParticleBuffers all(device, GaussianSet(SetKind::kCamera, 0, 0), Precision::kFloat);
  const shared::FrameParams frame{.particles = 9,
                                  .stride = 16,
                                  .tiles_x = 4,
                                  .tiles_y = 2,
                                  .rows = 32,
                                  .tile_rays = SIM_TILE_RAYS,
                                  .row_slots = 1,
                                  .slots = 0};
  buffers.projected.footprints.assign(
      std::vector<shared::Footprint>(9, {SIM_COLUMNS(0U, 15U), 0, 31U << 16U, 2U << 16U}));  // all 8 tiles
  RayLayout layout(device);
  const RequestedRays requested(device);
  const RayBuffers rays{layout, requested};
  layout.tile_rows.assign(std::vector<std::uint32_t>{0, 16, 32});
  buffers.projected.keys.assign(std::vector<std::uint32_t>(9, 5));
  buffers.projected.live.assign(std::vector<std::uint32_t>(1, 1));
  bin.run(frame, all, rays, buffers.projected, 72, buffers.binned);
  EXPECT_EQ(buffers.binned.pairs, 72U);
  try {
    bin.run(frame, all, rays, buffers.projected, 71, buffers.binned);
    FAIL() << "72 instances were taken where 71 are allowed";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
    EXPECT_NE(std::string(error.what()).find("found 72 tile instances, allowed 71"), std::string::npos)
        << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(WorkItems,
                         Bin,
                         testing::Values(std::size_t{1}, std::size_t{64}),
                         [](const auto& pair) {
                           return std::string(pair.param == 1 ? "cpu" : "gpu");
                         });

/// Returns the alpha of the particle on the ray, without its box; 0 behind the ray's origin.
double alpha_of(const reference::Footprint& f, const Eigen::Vector3d& mean, const reference::Ray& ray) {
  const Eigen::Matrix3d unit_from_scene =
      f.filtered_scale.cwiseInverse().asDiagonal() * f.scene_from_particle.transpose();
  const Eigen::Vector3d o = unit_from_scene * (ray.origin - mean);
  const Eigen::Vector3d d = unit_from_scene * ray.direction;
  if (!(o.dot(d) < 0.0)) return 0.0;
  return f.opacity * std::exp(-0.5 * o.cross(d).squaredNorm() / d.squaredNorm());
}

class BinOfScenes : public testing::TestWithParam<SceneCase> {};

TEST_P(BinOfScenes, NoRayMissesAParticleThatItMeets) {
  const SceneCase& scene = GetParam();
  const bool camera = scene.kind == SetKind::kCamera;
  const Device& device = test::device();
  RenderOptions options = paper_options();
  Renderer renderer(device, options);
  const test::SetRecipe recipe{
      .count = 500, .low = {-12, -12, -4}, .high = {12, 12, 4}, .scale_min = 0.05, .scale_max = 0.8};
  const GaussianSet set = test::set_for(scene, recipe, 13);
  const test::Shot shot = camera ? test::shot_of(scene, 72, 50) : test::shot_of(scene, 150, 20);
  const SensorRays rays = shot.on(device, options);
  Pass pass = renderer.render(ParticleBuffers(device, set, Precision::kFloat), rays, shot.view);
  const auto lists = checked_lists(pass.frame(), pass.buffers());

  const reference::Sensor sensor = shot.reference();
  const auto footprints = reference::project(reference::Particles(set), sensor);
  const auto all_rays = reference::rays(sensor);
  // A float box may be smaller by this share of its half-width.
  constexpr double kFloatShare = 1e-3;
  const double alpha_cut = options.alpha_cut * (1.0 + kFloatShare);
  std::size_t needed = 0, at_seam_low = 0, at_seam_high = 0;
  const auto& ray_of_slot = rays.grid().ray_of_slot;
  for (std::uint32_t slot = 0; slot < ray_of_slot.size(); ++slot) {
    if (ray_of_slot[slot] < 0) continue;
    const reference::Ray& ray = all_rays[static_cast<std::size_t>(ray_of_slot[slot])];
    for (std::uint32_t particle = 0; particle < footprints.size(); ++particle) {
      const reference::Footprint& f = footprints[particle];
      if (!f.visible) continue;
      double dx = std::abs(ray.x - f.mean.x());
      if (!camera) dx = std::min(dx, std::abs(ray.x - f.other_x));
      if (!(dx <= f.half_width.x() * (1.0 - kFloatShare))) continue;
      if (!(std::abs(ray.y - f.mean.y()) <= f.half_width.y() * (1.0 - kFloatShare))) continue;
      // Boxes are wider than the visible part, with different margins.
      if (!(alpha_of(f, set.mean().row(particle).transpose().cast<double>(), ray) >= alpha_cut)) continue;
      ++needed;
      const auto found = lists.find({slot / rays.grid().frame.tile_rays, particle});
      ASSERT_NE(found, lists.end()) << "ray " << ray_of_slot[slot] << " particle " << particle;
      const std::uint32_t ray_block = slot % rays.grid().frame.tile_rays / SIM_RAY_BLOCK;
      const std::uint32_t first = found->second.first_ray_block, last = found->second.last_ray_block;
      const auto within = [&](std::uint32_t share) {  // blocks: of their rows, and of their columns
        return first / share <= ray_block / share && ray_block / share <= last / share;
      };
      ASSERT_TRUE(within(camera ? 4 : 1)) << "ray " << ray_of_slot[slot] << " particle " << particle;
      ASSERT_TRUE(!camera || (first % 4 <= ray_block % 4 && ray_block % 4 <= last % 4))
          << "ray " << ray_of_slot[slot] << " particle " << particle;
      at_seam_low += ray.x < 0.1 ? 1U : 0U;
      at_seam_high += ray.x > 2.0 * std::numbers::pi - 0.1 ? 1U : 0U;
    }
  }
  EXPECT_GT(needed, all_rays.size());
  if (!camera) {
    EXPECT_GT(at_seam_low, 10U);
    EXPECT_GT(at_seam_high, 10U);
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         BinOfScenes,
                         testing::Values(test::kCameraRolling, test::kLidarStill, test::kLidarMoving),
                         [](const auto& pair) { return std::string(pair.param.name); });

TEST(BinOfRings, HoldTheRowsOfTheWholeSweep) {
  // At mid frame the sensor is above the particle, a ring far below the lowest beam; at the start, when it
  // measures there, the particle is a metre behind and reaches the beams.
  test::Shot shot = test::shot_of(test::kLidarMoving, 150, 20);
  shot.lidar.range_min = 0.1;
  shot.view.scene_from_sensor_end = shot.view.scene_from_sensor_start;
  shot.view.scene_from_sensor_end.translation.x() -= 2.0;
  const GaussianSet flat =
      test::set_of(SetKind::kLidar,
                   {{.mean = {-1.2, 0.0, -1.2}, .scale = Eigen::Vector3d::Constant(0.3), .opacity = 0.9}});
  GaussianSet set(SetKind::kLidar, test::kLidarMoving.sh_degree, 1);
  set.params.leftCols(flat.params.cols()) = flat.params;

  const Device& device = test::device();
  const RenderOptions options = paper_options();
  Renderer renderer(device, options);
  const SensorRays rays = shot.on(device, options);
  const RayResults found =
      renderer.render(ParticleBuffers(device, set, options.precision), rays, shot.view).results();
  const auto expected =
      reference::render(reference::Particles(set), shot.reference(), {}, Eigen::Vector3d::Zero());
  constexpr double kDecided = 1e-3;  // a decision within this margin may differ
  std::size_t met = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!(expected[i].margin >= kDecided)) continue;
    met += expected[i].contributors > 0 ? 1U : 0U;
    ASSERT_NEAR(static_cast<double>(found.transmittance[i]), expected[i].transmittance, 1e-4) << "ray " << i;
  }
  EXPECT_GT(met, 20U);
}

}  // namespace
}  // namespace simuli
