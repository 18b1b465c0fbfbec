#include "bench/render/scene.hpp"

namespace simuli::bench {

Pose world_from_bench_camera() {
  Eigen::Matrix3d rotation;  // columns: camera x (right), y (down), z (forward) in the world
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Eigen::Quaterniond(rotation), {0.0, -1.7, 1.6}};
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

}  // namespace simuli::bench
