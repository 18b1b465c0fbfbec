#include "host/core/sensors/sensor.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "host/core/sensors/lidar_library.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/support/scenes.hpp"

namespace simuli {
namespace {

TEST(Sensor, TakesAsLongAsItsModelSays) {
  EXPECT_EQ(Sensor(builtin_lidar("hesai_xt32@20")).duration_s(), 0.05);
  EXPECT_EQ(Sensor(builtin_lidar("hesai_xt32")).duration_s(), 0.1);
  EXPECT_EQ(Sensor(test::small_camera(8, 6)).duration_s(), 0.0);
  EXPECT_EQ(Sensor(test::small_camera(8, 6), {}, 0.02).duration_s(), 0.02);
  const Sensor slower = Sensor(builtin_lidar("hesai_xt32@20")).with_duration(0.1);
  EXPECT_EQ(slower.duration_s(), 0.1);
  EXPECT_EQ(sweep_s(slower.lidar()), 0.1);
}

TEST(Sensor, FiresBeamsAtSharesOfItsOwnTurn) {
  Lidar lidar = test::small_lidar(2, 10);
  lidar.rows[1].time_offset = 0.001;
  EXPECT_NEAR(Sensor(lidar).rays().time_fraction[10], 0.05 + 0.01, 1e-6);
  EXPECT_NEAR(Sensor(lidar).with_duration(0.05).rays().time_fraction[10], 0.05 + 0.02, 1e-6);
}

TEST(Sensor, IsFoundAgainByItsNumbers) {
  const Sensor lidar(test::small_lidar(4, 20));
  const Sensor again = Sensor(test::small_lidar(4, 20)).mounted({Eigen::Quaterniond::Identity(), {1, 2, 3}});
  EXPECT_TRUE(lidar.has_rays_of(again));
  EXPECT_EQ(lidar.rays_hash(), again.rays_hash());
  Lidar other = test::small_lidar(4, 20);
  other.rows[3].radial_offset = 1e-9;
  EXPECT_FALSE(lidar.has_rays_of(Sensor(other)));
  EXPECT_FALSE(lidar.has_rays_of(lidar.with_duration(0.2)));
  LidarRays rays = lidar.rays();
  rays.azimuth[7] += 1e-3F;
  EXPECT_FALSE(lidar.has_rays_of(lidar.with_rays(rays)));
  EXPECT_TRUE(lidar.with_rays(rays).has_rays_of(again.with_rays(rays)));
  const Sensor camera(test::small_camera(8, 6));
  EXPECT_FALSE(lidar.has_rays_of(camera));
  EXPECT_FALSE(camera.has_rays_of(camera.resized(16, 12)));
  EXPECT_TRUE(camera.has_rays_of(camera.named("another")));
}

TEST(Sensor, NameOutlivesOtherHandles) {
  const Sensor kept = Sensor(test::small_camera(8, 6)).named("front");
  const char* const name = kept.name().c_str();
  std::vector<Sensor> rig{kept};
  const char* const in_rig = rig.front().name().c_str();
  for (int i = 0; i < 100; ++i) rig.push_back(kept.named("more"));
  EXPECT_EQ(name, in_rig);
  EXPECT_EQ(rig.front().name().c_str(), in_rig);
}

TEST(Sensor, RefusesWhatNoSensorHas) {
  Camera camera = test::small_camera(8, 6);
  camera.fx = -1.0;
  expect_error(ErrorKind::kInput, "fx", [&] { (void)Sensor(camera); });
  Lidar lidar = test::small_lidar(2, 10);
  for (const double sweep_s : {0.0, -0.1, std::numeric_limits<double>::quiet_NaN(), 1e6}) {
    lidar.sweep_s = sweep_s;
    expect_error(ErrorKind::kInput, "sweep_s", [&] { (void)Sensor(lidar); });
  }
  lidar.sweep_s = 0.1;
  const Sensor fine(lidar);
  expect_error(ErrorKind::kInput, "sweep_s", [&] { (void)fine.with_duration(0.0); });
  expect_error(ErrorKind::kInput, "20 of each", [&] { (void)fine.with_rays({}); });
  expect_error(ErrorKind::kUsage, "allowed a camera", [&] { (void)fine.camera(); });
  const Sensor picture(test::small_camera(8, 6));
  expect_error(ErrorKind::kUsage, "allowed a LiDAR", [&] { (void)picture.lidar(); });
  expect_error(ErrorKind::kInput, "duration", [&] { (void)picture.with_duration(-1.0); });
}

TEST(Sensor, RefusesWhatIsNoName) {
  const Sensor fine(test::small_camera(8, 6));
  Camera camera = test::small_camera(8, 6);
  Lidar lidar = test::small_lidar(2, 10);
  for (const char* const name : {"", "../x", "a\nb", ".hidden"}) {
    camera.name = lidar.name = name;
    expect_error(ErrorKind::kInput, "sensor: name: found \"", [&] { (void)Sensor(camera); });
    expect_error(ErrorKind::kInput, "sensor: name: found \"", [&] { (void)Sensor(lidar); });
    expect_error(ErrorKind::kInput, "allowed a name: 1 to 128 bytes", [&] { (void)fine.named(name); });
  }
}

}  // namespace
}  // namespace simuli
