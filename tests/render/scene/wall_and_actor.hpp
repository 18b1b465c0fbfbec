#pragma once
// A scene with distinct depths and actors: a wall, an actor in front of it, another behind the sensor.
#include "host/device/render/scene/scene_on_device.hpp"
#include "tests/support/scenes.hpp"

namespace simuli::test {

inline constexpr double kWallYaw = 0.4;

inline Sensor still_camera() { return Sensor(small_camera(48, 32), forward_from_camera()); }
inline Sensor still_lidar() { return Sensor(small_lidar(16, 180)); }
inline Shot at_origin(const Sensor& sensor) { return Shot::at(sensor, {}, 0.0); }

/// Returns a wall rotated to the left with its centre 10 m ahead, and an actor's smaller wall 5 m ahead.
inline Scene wall_and_actor() {
  Scene scene;
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(kWallYaw, Eigen::Vector3d::UnitZ()));
  const SingleParticle wall{{10.0, 0.0, 0.0}, {1e-3, 6.0, 6.0}, turned, 0.99};
  const SingleParticle own{{0.0, 0.0, 0.0}, {1e-3, 0.5, 0.5}, Eigen::Quaterniond::Identity(), 0.99};
  scene.camera = set_of(SetKind::kCamera, {wall, own});
  scene.lidar = set_of(SetKind::kLidar, {wall, own});
  scene.camera.actor = scene.lidar.actor = {0, 2};
  scene.lidar_background = {0.5F, 2.0F, -2.0F};
  for (const double x : {-50.0, 5.0}) {
    Actor actor{x < 0.0 ? "behind" : "ahead", "car", {2.0, 2.0, 2.0}, {}};
    actor.track = {{0.0, {Eigen::Quaterniond::Identity(), {x, 0.0, 0.0}}}};
    scene.actors.push_back(actor);
  }
  return scene;
}

}  // namespace simuli::test
