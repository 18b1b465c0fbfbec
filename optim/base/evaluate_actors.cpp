#include "optim/base/evaluate_actors.hpp"

namespace simuli {

std::vector<int> pixels_on_actors(const ActorBoxes& boxes, const Camera& camera) {
  std::vector<int> on;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
      const Eigen::Vector3d direction = camera.unproject(pixel);
      const bool has_ray = !direction.isZero(0.0);
      on.push_back(has_ray
                       ? boxes.met_first(Eigen::Vector3d::Zero(), direction, camera.exposure_fraction(pixel))
                       : ActorBoxes::kNone);
    }
  }
  return on;
}

std::vector<int> returns_on_actors(const ActorBoxes& boxes,
                                   const LidarModel& lidar,
                                   const LidarRays& rays,
                                   const std::vector<float>& range) {
  std::vector<int> on(range.size(), ActorBoxes::kNone);
  for (std::size_t i = 0; i < range.size(); ++i) {
    if (!(range[i] > 0.0F)) continue;
    on[i] = boxes.around(ray_origin(lidar, rays, i),
                         Lidar::direction(rays.azimuth[i], rays.elevation[i]),
                         range[i],
                         rays.time_fraction[i]);
  }
  return on;
}

}  // namespace simuli
