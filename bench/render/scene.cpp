#include "bench/render/scene.hpp"

#include "bench/particles/particle_street.hpp"
#include "host/core/sensors/lidar_library.hpp"

namespace simuli::bench {

Pose world_from_bench_camera() {
  Eigen::Matrix3d rotation;  // columns: camera x (right), y (down), z (forward) in the world
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Eigen::Quaterniond(rotation), {0.0, -1.7, 1.6}};
}

Pose world_from_bench_sensor(SetKind kind) {
  return kind == SetKind::kCamera ? world_from_bench_camera() : world_from_street_lidar();
}

Camera bench_camera() {
  Camera camera;
  camera.name = "bench";
  camera.width = 640;
  camera.height = 360;
  camera.fx = camera.fy = 380.0;
  camera.cx = 320.0;
  camera.cy = 180.0;
  return camera;
}

SensorRays bench_rays(const Device& device, SetKind kind, const RenderOptions& options) {
  if (kind == SetKind::kCamera) return {device, bench_camera(), options};
  const Lidar lidar = builtin_lidar("generic64");
  return {device, lidar, nominal_rays(lidar), options};
}

}  // namespace simuli::bench
