#include "optim/eval/returns_near.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {
namespace {

template <class Frame>
double middle_of_s(const Frame& frame) {
  return 0.5 * (frame.time_start_s + frame.time_end_s);
}

}  // namespace

std::optional<std::size_t> ReturnsNear::nearest_sweep(const ImageFrame& frame) const {
  std::optional<std::size_t> nearest;
  double nearest_s = kFarthest_s;
  for (std::size_t i = 0; i < log_.sweeps.size(); ++i) {
    const double apart_s = std::abs(middle_of_s(log_.sweeps[i]) - middle_of_s(frame));
    if (apart_s > nearest_s) continue;
    nearest_s = apart_s;
    nearest = i;
  }
  return nearest;
}

void ReturnsNear::place(std::size_t index) {
  if (placed_ == index) return;
  const SweepFrame& frame = log_.sweeps[index];
  const LidarModel& lidar = log_.lidar(frame.lidar).model;
  const Sweep sweep = read_sweep(log_, frame, lidar);
  const View view = view_of(log_, scene_, frame);
  p_scene_.clear();
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (!(sweep.range[i] > 0.0F)) continue;
    const Eigen::Vector3d p_lidar = ray_origin(lidar, sweep.rays, i) +
                                    static_cast<double>(sweep.range[i]) *
                                        Lidar::direction(sweep.rays.azimuth[i], sweep.rays.elevation[i]);
    p_scene_.emplace_back(
        interpolate(view.scene_from_sensor_start, view.scene_from_sensor_end, sweep.rays.time_fraction[i]) *
        p_lidar);
  }
  placed_ = index;
}

std::vector<SeenReturn> ReturnsNear::in(const ImageFrame& frame, const Camera& camera) {
  const std::optional<std::size_t> sweep = nearest_sweep(frame);
  if (!sweep) return {};
  place(*sweep);
  const View view = view_of(log_, scene_, frame);
  const ImageView picture(camera, view.scene_from_sensor_start, view.scene_from_sensor_end);
  std::map<std::size_t, double> nearest_m;  // by pixel
  for (const Eigen::Vector3d& p : p_scene_) {
    Eigen::Vector2d pixel;
    double range_m = 0.0;
    if (!picture.project(p, pixel, range_m)) continue;
    const auto column = static_cast<std::size_t>(std::clamp(pixel.x(), 0.0, camera.width - 1.0));
    const auto row = static_cast<std::size_t>(std::clamp(pixel.y(), 0.0, camera.height - 1.0));
    const auto at =
        nearest_m.try_emplace(row * static_cast<std::size_t>(camera.width) + column, range_m).first;
    at->second = std::min(at->second, range_m);
  }
  std::vector<SeenReturn> seen;
  for (const auto& [pixel, range_m] : nearest_m) seen.push_back({pixel, range_m});
  return seen;
}

}  // namespace simuli
