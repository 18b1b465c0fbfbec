// Tests rays in tiles: each in one slot, in the tile whose list contains particles on the ray.
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

/// Expects that each ray has exactly one slot, empty slots are zero, and directions have unit length.
void expect_complete(const RayGrid& grid) {
  const std::size_t slots = grid.frame.slots;
  ASSERT_EQ(slots, std::size_t{grid.frame.tiles_x} * grid.frame.tiles_y * grid.frame.tile_rays);
  ASSERT_EQ(grid.ray_of_slot.size(), slots);
  ASSERT_EQ(grid.u.size(), slots);
  ASSERT_EQ(grid.sensor_ray.size(), 7 * slots);
  std::vector<int> seen(grid.rays, 0);
  for (std::size_t slot = 0; slot < slots; ++slot) {
    double length2 = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = static_cast<double>(grid.sensor_ray[k * slots + slot]);
      length2 += d * d;
    }
    const std::int32_t ray = grid.ray_of_slot[slot];
    if (ray < 0) {
      ASSERT_EQ(ray, -1);
      ASSERT_EQ(length2, 0.0);
      continue;
    }
    ASSERT_LT(static_cast<std::size_t>(ray), grid.rays);
    ++seen[static_cast<std::size_t>(ray)];
    ASSERT_NEAR(length2, 1.0, 1e-6);  // three floats
  }
  ASSERT_TRUE(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
}

/// Expects that slots of a sweep are in their beam's slot rows and in the tile column of their spin angle,
/// the azimuth in the revolution of their time.
void expect_lidar_places(const RayGrid& grid, const LidarRays& rays) {
  const auto& frame = grid.frame;
  const double first = grid.model.tile_first;
  const double width = 1.0 / grid.model.tile_scale;
  const double span = 1.0 / grid.model.inv_span;
  for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
    const std::int32_t ray = grid.ray_of_slot[slot];
    if (ray < 0) continue;
    const std::size_t tile = slot / frame.tile_rays;
    const auto row = static_cast<std::size_t>(ray) / static_cast<std::size_t>(rays.columns);
    const std::size_t ray_block = slot % frame.tile_rays / SIM_RAY_BLOCK;
    ASSERT_EQ(grid.tile_rows[tile / frame.tiles_x] + ray_block / frame.row_slots, row) << "ray " << ray;
    constexpr double kFloat_rad = 1e-6;
    const double u = static_cast<double>(grid.u[slot]);
    const double left = first + static_cast<double>(tile % frame.tiles_x) * width;
    ASSERT_GE(u, left - kFloat_rad) << "ray " << ray;
    ASSERT_LE(u, left + width + kFloat_rad) << "ray " << ray;
    const double azimuth = static_cast<double>(rays.azimuth[static_cast<std::size_t>(ray)]);
    const double turned = grid.model.spin * (azimuth - grid.model.azimuth_cut);
    ASSERT_NEAR(std::remainder(u - turned, 2.0 * kPi), 0.0, kFloat_rad) << "ray " << ray;
    const double by_time = static_cast<double>(rays.time_fraction[static_cast<std::size_t>(ray)]) * span;
    ASSERT_LE(std::abs(u - by_time), kPi + kFloat_rad) << "ray " << ray;
  }
}

LidarRays jittered(const Lidar& lidar, double share_of_column, std::uint64_t seed) {
  LidarRays rays = nominal_rays(lidar);
  test::Random random(seed);
  const double column_rad = lidar.azimuth_span / lidar.columns;
  for (float& azimuth : rays.azimuth) {
    const double moved =
        static_cast<double>(azimuth) + column_rad * random.uniform(-share_of_column, share_of_column);
    azimuth = static_cast<float>(std::remainder(moved, 2.0 * kPi));
  }
  for (float& elevation : rays.elevation) elevation += static_cast<float>(random.uniform(-1e-3, 1e-3));
  return rays;
}

TEST(RayGrid, PicturesOfAnySizeAreComplete) {
  for (const auto& [width, height] : {std::pair(1, 1), {16, 16}, {17, 33}, {100, 15}, {31, 1}, {1, 100}}) {
    Camera camera = test::small_camera(width, height, ShutterKind::kTopToBottom);
    camera.fx = camera.fy = 60.0;  // all pixels have a ray
    const RayGrid grid = make_ray_grid(camera, {});
    ASSERT_EQ(grid.rays, static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    expect_complete(grid);
    for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
      const std::int32_t ray = grid.ray_of_slot[slot];
      if (ray < 0) continue;
      // A pixel's tile and block follow from its column and row.
      const int x = ray % width, y = ray / width;
      const auto tile = static_cast<int>(slot / SIM_TILE_RAYS);
      const auto columns = static_cast<int>(grid.frame.tiles_x);
      ASSERT_EQ(tile, y / 16 * columns + x / 16);
      const int block = y % 16 / 4 * 4 + x % 16 / 4;
      ASSERT_EQ(static_cast<int>(slot % SIM_TILE_RAYS), block * 16 + y % 4 * 4 + x % 4);
      ASSERT_EQ(grid.u[slot], static_cast<float>(x) + 0.5F);
    }
  }
}

TEST(RayGrid, SweepsAreComplete) {
  for (const auto& [rows, columns] : {std::pair(1, 1), {1, 500}, {20, 150}, {33, 7}, {64, 257}}) {
    const Lidar lidar = test::small_lidar(rows, columns);
    const LidarRays nominal = nominal_rays(lidar);
    const RayGrid grid = make_ray_grid(test::device(), lidar, nominal);
    expect_complete(grid);
    expect_lidar_places(grid, nominal);
    const LidarRays measured = jittered(lidar, 2.0, 3);
    const RayGrid uneven = make_ray_grid(test::device(), lidar, measured);
    expect_complete(uneven);
    expect_lidar_places(uneven, measured);
  }
}

TEST(RayGrid, BuiltInLidarsAreComplete) {
  for (const std::string& name : builtin_lidar_names()) {
    SCOPED_TRACE(name);
    const Lidar lidar = builtin_lidar(name);
    const LidarRays rays = nominal_rays(lidar);
    const RayGrid grid = make_ray_grid(test::device(), lidar, rays);
    expect_complete(grid);
    expect_lidar_places(grid, rays);
  }
}

TEST(RayGrid, PartOfATurnAndAzimuthsFromAnywhere) {
  Lidar lidar = test::small_lidar(8, 400);
  lidar.azimuth_first = -0.4;
  lidar.azimuth_span = 0.8;
  const LidarRays narrow = nominal_rays(lidar);
  const RayGrid grid = make_ray_grid(test::device(), lidar, narrow);
  expect_complete(grid);
  expect_lidar_places(grid, narrow);

  // Azimuths from 0 to 2 pi instead of -pi to pi: the same tiles and positions.
  const Lidar full = test::small_lidar(8, 400);
  const LidarRays centred = nominal_rays(full);
  LidarRays turned = centred;
  for (float& a : turned.azimuth) {
    if (a < 0.0F) a = static_cast<float>(static_cast<double>(a) + 2.0 * kPi);
  }
  const RayGrid from_zero = make_ray_grid(test::device(), full, turned);
  expect_complete(from_zero);
  expect_lidar_places(from_zero, turned);
  EXPECT_EQ(from_zero.frame.tiles_x, make_ray_grid(test::device(), full, centred).frame.tiles_x);
}

std::string refusal(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was refused";
  return {};
}

TEST(RayGrid, WrongRaysAreRefused) {
  const Lidar lidar = test::small_lidar(4, 30);
  const LidarRays good = nominal_rays(lidar);
  const auto refused = [&](const std::function<void(LidarRays&)>& spoil, const std::string& part) {
    LidarRays rays = good;
    spoil(rays);
    const std::string message =
        refusal([&] { static_cast<void>(make_ray_grid(test::device(), lidar, rays)); });
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  refused([](LidarRays& r) { r.rows = 3; }, "rays");
  refused([](LidarRays& r) { r.columns = 29; }, "rays");
  refused([](LidarRays& r) { r.columns = 0; }, "rays");
  refused([](LidarRays& r) { r.azimuth.pop_back(); }, "rays");
  refused([](LidarRays& r) { r.elevation.push_back(0.0F); }, "rays");
  refused([](LidarRays& r) { r.time_fraction.clear(); }, "rays");
  refused([](LidarRays& r) { r.azimuth[7] = kNan; }, "ray 7");
  refused([](LidarRays& r) { r.elevation[8] = kNan; }, "ray 8");
  refused([](LidarRays& r) { r.time_fraction[9] = std::numeric_limits<float>::infinity(); }, "ray 9");
  // More rays of one beam in one direction than a tile holds.
  const Lidar dense = test::small_lidar(4, 3000);
  LidarRays bundled = nominal_rays(dense);
  std::fill(bundled.azimuth.begin(), bundled.azimuth.end(), 0.5F);
  EXPECT_NE(
      refusal([&] { static_cast<void>(make_ray_grid(test::device(), dense, bundled)); }).find("ray azimuths"),
      std::string::npos);
}

/// Places a small particle on each sampled ray at 20 m, renders, and checks these rays.
void expect_small_particles_seen(const test::Shot& shot, const std::vector<std::size_t>& sampled) {
  const Device& device = test::device();
  const auto rays = reference::rays(shot.reference());
  std::vector<test::SingleParticle> particles;
  for (const std::size_t ray : sampled) {
    particles.push_back({.mean = rays[ray].origin + 20.0 * rays[ray].direction,
                         .scale = Eigen::Vector3d::Constant(0.03),
                         .opacity = 0.9});
  }
  // The degree of a variant compiled for other tests.
  const GaussianSet flat = test::set_of(shot.kind, particles);
  GaussianSet set(shot.kind, 1, flat.size());
  set.params.leftCols(flat.params.cols()) = flat.params;
  RenderOptions options = paper_options();
  Renderer renderer(device, options);
  const SensorRays on_device = shot.on(device, options);
  const RayResults results =
      renderer.render(ParticleBuffers(device, set, options.precision), on_device, shot.view).results();
  // The particle's centre absorbs 0.9; float positions at 20 m have an error of 1e-6 m.
  for (const std::size_t ray : sampled) ASSERT_LT(results.transmittance[ray], 0.105F) << "ray " << ray;
  // A ray without its own particle has a high transmittance: the test above can fail.
  EXPECT_GT(*std::max_element(results.transmittance.begin(), results.transmittance.end()), 0.95F);
}

/// Returns one or two rays of each tile, never neighbours.
std::vector<std::size_t> sample_of_tiles(const RayGrid& grid) {
  std::vector<std::size_t> sampled;
  const std::size_t tile_rays = grid.frame.tile_rays;
  for (std::size_t tile = 0; tile < grid.ray_of_slot.size() / tile_rays; ++tile) {
    for (const std::size_t slot : {std::size_t{0}, std::size_t{100}, std::size_t{251}}) {
      const std::int32_t ray = grid.ray_of_slot[tile * tile_rays + slot];
      if (ray >= 0) sampled.push_back(static_cast<std::size_t>(ray));
    }
  }
  return sampled;
}

TEST(SmallParticles, AreSeenInEveryTileOfAPicture) {
  const test::Shot shot = test::shot_of(test::kCameraRolling, 90, 70);
  expect_small_particles_seen(shot, sample_of_tiles(make_ray_grid(shot.camera, {})));
}

TEST(SmallParticles, AreSeenInEveryTileOfASweepAndAtItsSeam) {
  test::Shot shot = test::shot_of(test::kLidarMoving, 150, 20);
  for (const double jitter : {0.0, 0.4}) {
    if (jitter > 0.0) shot.rays = jittered(shot.lidar, jitter, 5);
    std::vector<std::size_t> sampled = sample_of_tiles(make_ray_grid(test::device(), shot.lidar, shot.rays));
    // Both sides of the seam at +-pi, which is also the sweep's cut: first and last columns of each beam.
    std::size_t low = 0, high = 0;
    for (std::size_t row = 0; row < 20; ++row) {
      const std::size_t first = row * 150;
      for (const std::size_t ray : {first, first + 1, first + 149}) {
        sampled.push_back(ray);
        const float azimuth = shot.rays.azimuth[ray];
        low += azimuth < -3.05F ? 1U : 0U;
        high += azimuth > 3.05F ? 1U : 0U;
      }
    }
    EXPECT_GT(low, 10U);
    EXPECT_GT(high, 10U);
    expect_small_particles_seen(shot, sampled);
  }
}

}  // namespace
}  // namespace simuli
