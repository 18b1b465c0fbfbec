// Tests all built-in LiDARs in tiles and on the device: each ray has a slot and intersects the particles on
// it.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

// A ray through the centre of a particle of opacity 0.95 has a transmittance of 0.05; a particle missing in
// the tile's list gives 1.
constexpr float kHit = 0.3F;

TEST(LidarTables, EveryRayOfEveryTableHasOneSlotInItsTile) {
  const Device& device = test::device();
  for (const std::string& name : builtin_lidar_names()) {
    const BuiltinLidar sensor = builtin_lidar_with_facts(name);
    const LidarRays rays = nominal_rays(sensor.model);
    const RayGrid grid = make_ray_grid(device, sensor.model, rays);
    ASSERT_EQ(grid.rays, sensor.model.ray_count()) << name;
    std::vector<int> seen(grid.rays, 0);
    const double first = grid.model.tile_first;
    const double width = 1.0 / grid.model.tile_scale;
    for (std::size_t slot = 0; slot < grid.ray_of_slot.size(); ++slot) {
      const std::int32_t ray = grid.ray_of_slot[slot];
      if (ray < 0) continue;
      ++seen[static_cast<std::size_t>(ray)];
      const std::size_t tile = slot / grid.frame.tile_rays;
      const std::size_t row = grid.tile_rows[tile / grid.frame.tiles_x] +
                              slot % grid.frame.tile_rays / SIM_RAY_BLOCK / grid.frame.row_slots;
      ASSERT_EQ(row, static_cast<std::size_t>(ray) / static_cast<std::size_t>(rays.columns)) << name;
      const double place = (static_cast<double>(grid.u[slot]) - first) / width;
      constexpr double kFloat = 1e-3;  // of a tile
      ASSERT_NEAR(place, static_cast<double>(tile % grid.frame.tiles_x) + 0.5, 0.5 + kFloat) << name;
    }
    ASSERT_TRUE(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; })) << name;
  }
}

/// Places small balls on some rays of `sensor`, at each ray's own time; returns the rays' indices in
/// `chosen`.
GaussianSet balls_on_rays(const BuiltinLidar& sensor,
                          const Pose& start,
                          const Pose& end,
                          std::vector<std::size_t>& chosen) {
  const Lidar& lidar = sensor.model;
  std::vector<test::SingleParticle> balls;
  chosen.clear();
  for (int row = 0; row < lidar.row_count(); row += std::max(1, lidar.row_count() / 32)) {
    for (const int column : {0, (lidar.columns / 5 + 37 * row) % lidar.columns, lidar.columns - 1}) {
      const std::size_t ray = static_cast<std::size_t>(row) * static_cast<std::size_t>(lidar.columns) +
                              static_cast<std::size_t>(column);
      if (!fires(lidar, ray)) continue;
      const double azimuth = lidar.azimuth(row, column);
      const double range = row % 2 == 0 ? 6.0 : 25.0;
      const Pose scene_from_sensor = interpolate(start, end, lidar.time_fraction(row, column));
      test::SingleParticle ball;
      ball.mean = scene_from_sensor *
                  Eigen::Vector3d(
                      lidar.origin(row, azimuth) +
                      range * Lidar::direction(azimuth, lidar.rows[static_cast<std::size_t>(row)].elevation));
      ball.scale = Eigen::Vector3d::Constant(0.004);
      ball.opacity = 0.95;
      balls.push_back(ball);
      chosen.push_back(ray);
    }
  }
  return test::set_of(SetKind::kLidar, balls);
}

void expect_hits(const Pose& start, const Pose& end) {
  const Device& device = test::device();
  const RenderOptions options = paper_options();
  Renderer renderer(device, options);
  for (const std::string& name : builtin_lidar_names()) {
    const BuiltinLidar sensor = builtin_lidar_with_facts(name);
    std::vector<std::size_t> chosen;
    const GaussianSet set = balls_on_rays(sensor, start, end, chosen);
    const SensorRays rays(device, sensor.model, nominal_rays(sensor.model), options);
    const std::vector<float> found =
        renderer.render(ParticleBuffers(device, set, Precision::kFloat), rays, {start, end, {}})
            .results()
            .transmittance;
    std::size_t missed = 0;
    for (const std::size_t ray : chosen) missed += found[ray] < kHit ? 0U : 1U;
    EXPECT_EQ(missed, 0U) << name << ": of " << chosen.size() << " balls";
  }
}

TEST(LidarTables, RaysMeetWhatStandsOnThem) { expect_hits({}, {}); }

TEST(LidarTables, MovingRaysMeetWhatStandsOnThem) {
  // 30 m/s and 90 degrees/s during a tenth of a second.
  const Pose start;
  Pose end;
  end.translation = {3.0, 0.0, 0.0};
  end.rotation = Eigen::AngleAxisd(kPi / 20.0, Eigen::Vector3d::UnitZ());
  expect_hits(start, end);
}

/// Returns the transmittance of all rays past a ball of radius 12 cm at `p_sensor`.
std::vector<float> past_ball(const Lidar& lidar, const LidarRays& rays, const Eigen::Vector3d& p_sensor) {
  const Device& device = test::device();
  Renderer renderer(device, paper_options());
  test::SingleParticle ball;
  ball.mean = p_sensor;
  ball.scale = Eigen::Vector3d::Constant(0.04);
  ball.opacity = 0.95;
  const SensorRays on_device(device, lidar, rays, paper_options());
  return renderer
      .render(
          ParticleBuffers(device, test::set_of(SetKind::kLidar, {ball}), Precision::kFloat), on_device, {})
      .results()
      .transmittance;
}

TEST(LidarTables, NothingIsSeenOutsideTheRangeLimits) {
  const Lidar lidar = builtin_lidar("velodyne_vlp16");  // 0.5 to 100 m
  const LidarRays rays = nominal_rays(lidar);
  const std::size_t ray = 3 * static_cast<std::size_t>(lidar.columns) + 500;
  const Eigen::Vector3d direction = Lidar::direction(lidar.azimuth(3, 500), lidar.rows[3].elevation);
  for (const double range : {0.52, 5.0, 99.9}) {
    EXPECT_LT(past_ball(lidar, rays, range * direction)[ray], kHit) << range;
  }
  for (const double range : {0.48, 100.1}) {
    EXPECT_EQ(past_ball(lidar, rays, range * direction)[ray], 1.0F) << range;
  }
}

TEST(LidarTables, MeasuredRaysTakeTheSameRoad) {
  const Lidar lidar = builtin_lidar("velodyne_hdl64e_s2_sztaki");
  LidarRays rays = nominal_rays(lidar);
  const std::size_t ray = 20 * static_cast<std::size_t>(lidar.columns) + 1234;
  // A measured ray with an offset of half a column and its own time.
  rays.azimuth[ray] += static_cast<float>(0.5 * lidar.azimuth_span / lidar.columns);
  rays.time_fraction[ray] += 1e-4F;
  const double azimuth = static_cast<double>(rays.azimuth[ray]);
  const Eigen::Vector3d p_sensor =
      lidar.origin(20, azimuth) + 60.0 * Lidar::direction(azimuth, lidar.rows[20].elevation);
  const float measured = past_ball(lidar, rays, p_sensor)[ray];
  const float nominal = past_ball(lidar, nominal_rays(lidar), p_sensor)[ray];
  EXPECT_LT(measured, kHit);
  EXPECT_GT(nominal, measured + 0.3F);  // half a column is 9 cm there
}

}  // namespace
}  // namespace simuli
