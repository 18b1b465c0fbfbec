#include "optim/init/posed_frames.hpp"

#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"

namespace simuli {
namespace {

Pose shifted(Pose world_from_sensor, const Eigen::Vector3d& origin) {
  world_from_sensor.translation -= origin;
  return world_from_sensor;
}

}  // namespace

Eigen::Vector3d scene_origin(const Trajectory& world_from_rig) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TimedPose& p : world_from_rig.poses()) sum += p.pose.translation;
  return (sum / static_cast<double>(world_from_rig.poses().size())).array().round();
}

SceneRay ray_in_scene(const PosedSweep& posed, std::size_t ray) {
  const LidarRays& rays = posed.sweep.rays;
  const Pose scene_from_lidar =
      interpolate(posed.scene_from_lidar_start, posed.scene_from_lidar_end, rays.time_fraction[ray]);
  return {scene_from_lidar * ray_origin(posed.lidar, rays, ray),
          scene_from_lidar.rotation * Lidar::direction(rays.azimuth[ray], rays.elevation[ray])};
}

PosedSweep load_sweep(const Log& log, const SweepFrame& frame, const Eigen::Vector3d& origin) {
  const LogLidar& lidar = log.lidar(frame.lidar);
  return {lidar.model,
          read_sweep(log, frame),
          shifted(log.world_from_rig.at(frame.time_start_s) * lidar.rig_from_lidar, origin),
          shifted(log.world_from_rig.at(frame.time_end_s) * lidar.rig_from_lidar, origin)};
}

ImageView image_view(const Log& log,
                     const ImageFrame& frame,
                     const Eigen::Vector3d& origin,
                     double image_scale) {
  const LogCamera& camera = log.camera(frame.camera);
  return {scaled_camera(camera.model, image_scale),
          shifted(log.world_from_rig.at(frame.time_start_s) * camera.rig_from_camera, origin),
          shifted(log.world_from_rig.at(frame.time_end_s) * camera.rig_from_camera, origin)};
}

std::pair<Image, ImageView> load_view(const Log& log,
                                      const ImageFrame& frame,
                                      const Eigen::Vector3d& origin,
                                      double image_scale) {
  ImageView view = image_view(log, frame, origin, image_scale);
  Image image = load_image(log, frame, view.camera());
  view.hide(image);
  return {std::move(image), std::move(view)};
}

}  // namespace simuli
