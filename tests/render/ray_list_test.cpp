// Tests ray lists: in tiles, and on the device against a sensor with beams.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace ray_list_test {

constexpr float kHit = 0.3F;  // as in lidar_tables_test.cpp

/// Returns a rosette about the x axis, as made by two rotating prisms: neighbours in time are no neighbours
/// in angle.
RayList rosette(std::size_t rays) {
  RayList list;
  list.name = "rosette";
  list.range_min = 0.2;
  list.range_max = 200.0;
  for (std::size_t i = 0; i < rays; ++i) {
    const double time = (static_cast<double>(i) + 0.5) / static_cast<double>(rays);
    const double radius = 0.335 * std::cos(2.0 * kPi * 23.7 * time);
    const double angle = 2.0 * kPi * 7.3 * time;
    list.azimuth.push_back(radius * std::cos(angle));
    list.elevation.push_back(radius * std::sin(angle));
    list.time_fraction.push_back(time);
    list.origin.emplace_back(0.0, 0.01 * std::cos(angle), 0.01 * std::sin(angle));
  }
  return list;
}

RayList list_of(const Lidar& lidar, const LidarRays& rays) {
  RayList list;
  list.name = "listed";
  list.range_min = lidar.range_min;
  list.range_max = lidar.range_max;
  for (std::size_t i = 0; i < rays.azimuth.size(); ++i) {
    const int row = static_cast<int>(i / static_cast<std::size_t>(rays.columns));
    list.azimuth.push_back(static_cast<double>(rays.azimuth[i]));
    list.elevation.push_back(static_cast<double>(rays.elevation[i]));
    list.time_fraction.push_back(static_cast<double>(rays.time_fraction[i]));
    list.origin.push_back(lidar.origin(row, list.azimuth.back()));
  }
  return list;
}

/// Expects each ray in one slot, in the tile of its azimuth and in a row whose elevations contain it.
void expect_complete(const RayList& list, const RayGrid& grid) {
  ASSERT_EQ(grid.rays, list.ray_count());
  const std::size_t rows = grid.frame.rows;
  ASSERT_EQ(grid.row_elevation.size(), 2 * rows);
  for (std::size_t row = 1; row < 2 * rows; ++row) {
    if (row == rows) continue;
    ASSERT_LE(grid.row_elevation[row], grid.row_elevation[row - 1]);
  }
  std::vector<int> seen(grid.rays, 0);
  for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
    if (grid.ray_of_slot[slot] < 0) continue;
    const auto ray = static_cast<std::size_t>(grid.ray_of_slot[slot]);
    ++seen[ray];
    const std::size_t tile = slot / grid.frame.tile_rays;
    const std::size_t row = grid.tile_rows[tile / grid.frame.tiles_x] +
                            slot % grid.frame.tile_rays / SIM_RAY_BLOCK / grid.frame.row_slots;
    ASSERT_LT(row, rows);
    ASSERT_LE(grid.row_elevation[row], list.elevation[ray]);
    ASSERT_GE(grid.row_elevation[rows + row], list.elevation[ray]);
    const double bin = (static_cast<double>(grid.u[slot]) - grid.model.tile_first) * grid.model.tile_scale;
    constexpr double kFloat = 1e-2;  // of a bin
    const auto column = [&](double b) {
      const double last = static_cast<double>(grid.column_of_bin.size() - 1);
      return grid.column_of_bin[static_cast<std::size_t>(std::clamp(b, 0.0, last))];
    };
    ASSERT_LE(column(bin - kFloat), tile % grid.frame.tiles_x);
    ASSERT_GE(column(bin + kFloat), tile % grid.frame.tiles_x);
    const double turned = static_cast<double>(grid.u[slot]) + grid.model.azimuth_cut;
    ASSERT_NEAR(std::remainder(turned - list.azimuth[ray], 2.0 * kPi), 0.0, 1e-6);
  }
  ASSERT_TRUE(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
}

TEST(RayListGrid, AnyListIsComplete) {
  const Device& device = test::device();
  for (const std::size_t rays : {1U, 2U, 257U, 24000U}) {
    const RayList list = rosette(rays);
    const RayGrid grid = make_ray_grid(device, list);
    expect_complete(list, grid);
    // Large lists use most slots of their tiles.
    if (rays == 24000U) {
      EXPECT_LT(grid.frame.slots, 3 * rays);
    }
  }
  const Lidar lidar = test::small_lidar(20, 300);
  const RayList turn = list_of(lidar, nominal_rays(lidar));
  expect_complete(turn, make_ray_grid(device, turn));
  RayList same = rosette(1000);
  std::fill(same.azimuth.begin(), same.azimuth.end(), 3.0);
  std::fill(same.elevation.begin(), same.elevation.end(), -0.2);
  expect_complete(same, make_ray_grid(device, same));
}

TEST(RayListGrid, BadListsAreRefused) {
  RayList list = rosette(10);
  list.azimuth[3] = std::nan("");
  EXPECT_THROW((void)make_ray_grid(test::device(), list), Error);
}

Pose drive() {
  Pose end;
  end.translation = {3.0, 0.4, 0.0};
  end.rotation = Eigen::AngleAxisd(kPi / 20.0, Eigen::Vector3d(0.05, 0.1, 1.0).normalized());
  return end;
}

std::vector<float> transmittance(const Device& device,
                                 const GaussianSet& set,
                                 const SensorRays& rays,
                                 const Pose& end) {
  Renderer renderer(device, paper_options());
  return renderer.render(ParticleBuffers(device, set, Precision::kFloat), rays, {{}, end, {}})
      .results()
      .transmittance;
}

TEST(RayListGrid, RaysMeetWhatStandsOnThem) {
  const RayList list = rosette(24000);
  for (const Pose& end : {Pose{}, drive()}) {
    std::vector<test::SingleParticle> balls;
    std::vector<std::size_t> chosen;
    for (std::size_t ray = 0; ray < list.ray_count(); ray += 97) {
      const double range = ray % 2 == 0 ? 8.0 : 40.0;
      test::SingleParticle ball;
      ball.mean = interpolate({}, end, list.time_fraction[ray]) *
                  Eigen::Vector3d(list.ray_origin(ray) + range * list.direction(ray));
      ball.scale = Eigen::Vector3d::Constant(0.004);
      ball.opacity = 0.95;
      balls.push_back(ball);
      chosen.push_back(ray);
    }
    const Device& device = test::device();
    const std::vector<float> found =
        transmittance(device,
                      test::set_of(SetKind::kLidar, balls),
                      SensorRays(device, list, nominal_rays(list), paper_options()),
                      end);
    std::size_t missed = 0;
    for (const std::size_t ray : chosen) missed += found[ray] < kHit ? 0U : 1U;
    EXPECT_EQ(missed, 0U) << "of " << chosen.size();
  }
}

TEST(RayListGrid, ListedRaysSeeWhatTheRowsSee) {
  const Lidar lidar = test::small_lidar(20, 300);
  const LidarRays rays = nominal_rays(lidar);
  test::SetRecipe recipe;
  recipe.kind = SetKind::kLidar;
  recipe.count = 300;
  recipe.low = {-12, -12, -4};
  recipe.high = {12, 12, 4};
  recipe.scale_min = 0.05;
  recipe.scale_max = 0.5;
  const GaussianSet set = test::random_set(recipe, 5);
  const Device& device = test::device();
  for (const Pose& end : {Pose{}, drive()}) {
    const std::vector<float> expected =
        transmittance(device, set, SensorRays(device, lidar, rays, paper_options()), end);
    const std::vector<float> found =
        transmittance(device, set, SensorRays(device, list_of(lidar, rays), rays, paper_options()), end);
    double sum = 0.0;
    int hit = 0;
    for (std::size_t ray = 0; ray < expected.size(); ++ray) {
      // Boxes of a list are wider: they include tails that a beam's box cuts off.
      ASSERT_NEAR(found[ray], expected[ray], 0.12F) << "ray " << ray;
      sum += std::abs(static_cast<double>(found[ray]) - static_cast<double>(expected[ray]));
      hit += expected[ray] < 0.9F ? 1 : 0;
    }
    EXPECT_LT(sum / static_cast<double>(expected.size()), 2e-3);
    EXPECT_GT(hit, 500);
  }
}

}  // namespace ray_list_test
}  // namespace simuli
