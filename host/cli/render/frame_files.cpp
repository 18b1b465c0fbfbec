#include "host/cli/render/frame_files.hpp"

#include <algorithm>

#include "host/cli/base/pictures.hpp"
#include "io/splat/cloud_file.hpp"

namespace simuli::cli {
namespace {

/// In the world one type holds all of a path's clouds.
CloudOptions cloud_options(const FileOptions& options, const LidarModel& lidar, const Plan& plan) {
  CloudOptions cloud;
  cloud.frame = point_frame(options.cloud_frame);
  if (cloud.frame != PointFrame::kWorld) return cloud;
  double farthest_m = 0.0;
  for (const TimedPose& p : plan.world_from_rig.poses()) {
    farthest_m = std::max(farthest_m, p.pose.translation.norm());
  }
  cloud.coordinates = coordinates_to_a_millimetre(farthest_m + range_max(lidar));
  return cloud;
}

}  // namespace

void add_file_options(Command sub, FileOptions& options) {
  sub.option("--images", options.images, "png, or exr with float colours")
      .one_of({"png", "exr"})
      .with_default();
  sub.option("--clouds", options.clouds, "ply, pcd or npz").one_of({"ply", "pcd", "npz"}).with_default();
  sub.option(
         "--cloud-frame",
         options.cloud_frame,
         "axes of points: world; sensor, at each ray's own time; or sensor_start, without its motion since "
         "the frame's start")
      .one_of({"world", "sensor", "sensor_start"})
      .with_default();
}

FrameFiles::FrameFiles(const FileOptions& options, const Sensor& sensor, const Plan& plan)
    : options_(options), is_camera_(sensor.is_camera()) {
  if (!is_camera_) cloud_ = cloud_options(options, sensor.lidar(), plan);
}

std::vector<std::string> FrameFiles::write(const Frame& frame,
                                           const std::filesystem::path& folder,
                                           const std::string& stem) const {
  std::vector<std::string> files;
  const auto file = [&](const std::string& ending) {
    files.push_back(stem + ending);
    return folder / files.back();
  };
  if (!is_camera_) write_point_cloud(file("." + options_.clouds), point_cloud(frame, cloud_));
  write_image(file(is_camera_ ? "." + options_.images : "_range.png"), shown(frame));
  return files;
}

void FrameFiles::describe(FramesRecord& record) const {
  if (is_camera_) return;
  const bool is_double = cloud_.coordinates == ColumnType::kDouble;
  record.clouds = {options_.cloud_frame, is_double ? "float64" : "float32"};
}

Image shown(const Frame& frame) {
  if (frame.sensor().is_camera()) return frame.image();
  const LidarFrame sweep = frame.lidar();
  return range_image(frame.sensor().lidar(), sweep.rays, sweep.range);
}

}  // namespace simuli::cli
