// The OpenCL forward pass against the sequential double-precision reference (tests/support).
#include <gtest/gtest.h>

#include <cmath>

#include "host/render/renderer.hpp"
#include "tests/support/reference.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace {

struct Case {
  const char* name;
  SetKind kind;
  bool moving;
  bool levers;
  int sh_degree;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class Forward : public testing::TestWithParam<std::tuple<Case, Precision, LaneShape>> {};

Lidar lidar_of(const Case& c) {
  Lidar lidar = test::small_lidar(20, 150);
  if (c.levers) {
    for (std::size_t r = 0; r < lidar.rows.size(); ++r) {
      lidar.rows[r].vertical_offset = 0.1 + 0.003 * static_cast<double>(r);
    }
  }
  return lidar;
}

TEST_P(Forward, MatchesTheReference) {
  const auto& [c, precision, shape] = GetParam();
  const GaussianSet set = test::random_set({c.kind, c.sh_degree, 400, {-12, -12, -4}, {12, 12, 4}, 0.05, 0.8}, 7);
  test::Random random(3);
  View view;
  const Pose base = c.kind == SetKind::kCamera ? test::forward_from_camera() : Pose{};
  view.world_from_sensor_start = base;
  view.world_from_sensor_end = base;
  if (c.moving) {
    view.world_from_sensor_end.translation += Eigen::Vector3d(0.6, 0.1, -0.05);
    view.world_from_sensor_end.rotation =
        base.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(0.06, Eigen::Vector3d(0.2, 0.9, 0.4).normalized()));
  }
  view.background = {0.2F, -1.0F, 1.5F};

  RenderOptions options;
  options.precision = precision;
  options.shape = shape;
  const Device device = Device::best();
  Renderer renderer(device, options);
  const Camera camera =
      test::small_camera(72, 50, c.moving ? ShutterKind::kTopToBottom : ShutterKind::kGlobal);
  const Lidar lidar = lidar_of(c);
  const LidarRays rays = nominal_rays(lidar, 0.1);
  const SensorRays sensor_rays = c.kind == SetKind::kCamera ? SensorRays(device, camera, options)
                                                            : SensorRays(device, lidar, rays, options);
  const reference::Sensor sensor =
      c.kind == SetKind::kCamera
          ? reference::Sensor::of(camera, view.world_from_sensor_start, view.world_from_sensor_end)
          : reference::Sensor::of(lidar, rays, view.world_from_sensor_start, view.world_from_sensor_end);

  const ParticleBuffers particles(device, set, precision);
  renderer.render(particles, sensor_rays, view);
  const RayResults results = renderer.results();
  const auto expected = reference::render(reference::Particles(set),
                                          sensor,
                                          {},
                                          {static_cast<double>(view.background[0]),
                                           static_cast<double>(view.background[1]),
                                           static_cast<double>(view.background[2])});
  ASSERT_EQ(results.rays, expected.size());

  // Downloads are float; a float pipeline adds the rounding of directions (6e-8) against scales of a few
  // centimetres some metres away, squared distances up to 11 and hundreds of terms.
  const double tolerance = precision == Precision::kDouble ? 2e-6 : 3e-3;
  const double decided = precision == Precision::kDouble ? 1e-6 : 1e-3;
  std::size_t compared = 0, covered = 0;
  double worst = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (expected[i].margin < decided) continue;
    ++compared;
    covered += expected[i].contributors > 0;
    for (int k = 0; k < 3; ++k) {
      const double found = static_cast<double>(results.feature[k][i]);
      worst = std::max(worst, std::abs(found - expected[i].feature[k]));
      ASSERT_NEAR(found, expected[i].feature[k], tolerance * 4) << "ray " << i << " channel " << k;
    }
    ASSERT_NEAR(static_cast<double>(results.transmittance[i]), expected[i].transmittance, tolerance) << "ray " << i;
    ASSERT_NEAR(static_cast<double>(results.distance[i]), expected[i].distance, tolerance * 20) << "ray " << i;
    if (c.kind == SetKind::kLidar && expected[i].median_margin > decided) {
      ASSERT_NEAR(static_cast<double>(results.median[i]), expected[i].median_distance, tolerance * 20) << "ray " << i;
    }
  }
  RecordProperty("compared", static_cast<int>(compared));
  EXPECT_GT(compared, expected.size() * (precision == Precision::kDouble ? 99 : 30) / 100);
  EXPECT_GT(covered, compared / 3);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    Forward,
    testing::Combine(testing::Values(Case{"camera", SetKind::kCamera, false, false, 0},
                                     Case{"camera_sh3", SetKind::kCamera, false, false, 3},
                                     Case{"camera_rolling", SetKind::kCamera, true, false, 1},
                                     Case{"lidar", SetKind::kLidar, false, false, 2},
                                     Case{"lidar_levers", SetKind::kLidar, false, true, 0},
                                     Case{"lidar_moving", SetKind::kLidar, true, true, 1}),
                     testing::Values(Precision::kFloat, Precision::kDouble),
                     testing::Values(LaneShape{16, 16, 1}, LaneShape{1, 4, 64}, LaneShape{4, 4, 16})),
    [](const auto& instance) {
      const auto& shape = std::get<2>(instance.param);
      return std::string(std::get<0>(instance.param).name) +
             (std::get<1>(instance.param) == Precision::kFloat ? "_float" : "_double") + "_lanes" +
             std::to_string(shape.lanes) + "x" + std::to_string(shape.work_items);
    });

}  // namespace
}  // namespace simuli
