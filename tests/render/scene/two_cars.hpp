#pragma once
// A scene for tests of frames: background and two moving cars, far from the world origin.
#include <string>
#include <vector>

#include "host/device/render/scene/scene_on_device.hpp"
#include "tests/support/scenes.hpp"

namespace simuli::test {

/// Powers of two: sums with coordinates around the sensor are exact.
inline const Eigen::Vector3d kOrigin{524288.0, 4194304.0, 128.0};

inline GaussianSet background_and_cars(SetKind kind) {
  const GaussianSet background =
      random_set({.kind = kind, .sh_degree = 1, .count = 120, .low = {-14, -14, -3}, .high = {14, 14, 1}}, 1);
  const GaussianSet car = random_set({.kind = kind,
                                      .sh_degree = 1,
                                      .count = 40,
                                      .low = {-2, -0.9, -0.7},
                                      .high = {2, 0.9, 0.7},
                                      .scale_max = 0.3},
                                     2);
  GaussianSet set(kind, 1, background.size() + 2 * car.size());
  set.params << background.params, car.params, car.params;
  for (const std::uint32_t actor : {0U, 1U, 2U}) {
    const Eigen::Index count = actor == 0 ? background.size() : car.size();
    set.actor.insert(set.actor.end(), static_cast<std::size_t>(count), actor);
  }
  return set;
}

/// Moves at 8 m/s and rotates.
inline Actor driving(const std::string& name, const Eigen::Vector3d& start, double yaw) {
  Actor actor{name, "car", {4.4, 2.0, 1.6}, {}};
  for (int i = 0; i < 4; ++i) {
    const Eigen::Quaterniond rotation(Eigen::AngleAxisd(yaw + 0.2 * i, Eigen::Vector3d::UnitZ()));
    const Eigen::Vector3d position = kOrigin + start + Eigen::Vector3d(0.8 * i, 0.3 * i, 0.0);
    actor.track.push_back({0.1 * i, {rotation, position}});
  }
  return actor;
}

inline Scene two_cars() {
  Scene scene;
  scene.origin = kOrigin;
  scene.camera = background_and_cars(SetKind::kCamera);
  scene.lidar = background_and_cars(SetKind::kLidar);
  scene.actors = {driving("near", {6.0, 1.0, -0.4}, 0.3), driving("far", {9.0, -2.5, 0.2}, -2.0)};
  scene.camera_background = {0.1F, 0.2F, 0.4F};
  scene.lidar_background = {0.5F, 2.0F, -2.0F};  // rays with a hit return
  return scene;
}

inline Camera rolling_camera() {
  Camera camera = small_camera(48, 32, ShutterKind::kTopToBottom);
  camera.name = "front";
  return camera;
}
inline Sensor camera() { return Sensor(rolling_camera(), forward_from_camera(), 0.02); }
inline Sensor lidar() { return Sensor(small_lidar(16, 180)); }

/// Returns an ego trajectory of 10 m/s along x.
inline Trajectory path() {
  std::vector<TimedPose> poses;
  for (int i = 0; i < 5; ++i) {
    poses.push_back({0.1 * i, {Eigen::Quaterniond::Identity(), kOrigin + Eigen::Vector3d(1.0 * i, 0, 0)}});
  }
  return Trajectory(poses);
}
inline Shot shot_of(const Sensor& sensor, double time_s) { return Shot::along(path(), sensor, time_s); }

}  // namespace simuli::test
