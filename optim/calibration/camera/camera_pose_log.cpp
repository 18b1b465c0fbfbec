// What the search for a camera's mounting reads of a log.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "host/core/base/spread.hpp"
#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/calibration/camera/camera_pose.hpp"

namespace simuli::calibration {

double beam_spacing(const Lidar& lidar) {
  std::vector<double> gaps;
  for (std::size_t r = 1; r < lidar.rows.size(); ++r) {
    gaps.push_back(std::abs(lidar.rows[r].elevation - lidar.rows[r - 1].elevation));
  }
  return gaps.empty() ? lidar.azimuth_span / lidar.columns : upper_median(std::move(gaps));
}

CameraPoseReport find_camera_pose(const Log& log,
                                  const std::string& camera,
                                  const std::string& lidar,
                                  const Trajectory& world_from_rig,
                                  std::size_t most_views,
                                  const CameraPoseOptions& options,
                                  const std::function<void(std::size_t, std::size_t)>& progress) {
  std::vector<const ImageFrame*> frames;
  for (const ImageFrame& frame : log.images) {
    if (frame.camera == camera) frames.push_back(&frame);
  }
  std::vector<CameraView> views;
  const std::size_t count = std::min(frames.size(), most_views);
  for (std::size_t i = 0; i < count; ++i) {
    const ImageFrame& frame = *frames[i * frames.size() / count];
    views.push_back(
        {Luminance(load_image(log, frame, log.camera(camera).model)), frame.time_start_s, frame.time_end_s});
  }
  const LogLidar& sensor = log.lidar(lidar);
  LidarScene scene;
  std::vector<Returns> sweeps;
  for (const SweepFrame& frame : log.sweeps) {
    if (frame.lidar != lidar) continue;
    const Sweep sweep = read_sweep(log, frame, sensor.model);
    const std::vector<DepthEdge> found = depth_edges(sweep, sensor, frame.time_start_s, frame.time_end_s);
    scene.edges.insert(scene.edges.end(), found.begin(), found.end());
    sweeps.push_back(returns_of(sweep, sensor, frame.time_start_s, frame.time_end_s));
  }
  std::stable_sort(scene.edges.begin(), scene.edges.end(), [](const DepthEdge& a, const DepthEdge& b) {
    return a.time_s < b.time_s;
  });
  scene.surfaces = surface_points(sweeps, world_from_rig);
  scene.spacing_rad = beam_spacing(sensor.with_rows());
  return find_camera_pose(views, log.camera(camera), world_from_rig, scene, options, progress);
}

}  // namespace simuli::calibration
