#pragma once
// Frames of a log with their poses in the scene.
#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "io/log/frame_selection.hpp"
#include "io/picture/image.hpp"
#include "optim/init/initialize_views.hpp"

namespace simuli {

/// Mean sensor position in whole metres: offsets from it are small and exact in float.
[[nodiscard]] Eigen::Vector3d scene_origin(const Trajectory& world_from_rig);

/// A sweep with the poses at its start and end. `lidar` belongs to the log.
struct PosedSweep {
  const LidarModel& lidar;
  Sweep sweep;
  Pose scene_from_lidar_start;
  Pose scene_from_lidar_end;
};
struct SceneRay {
  Eigen::Vector3d origin, direction;  // m, unit
};
/// Returns a ray (row-major) at its firing time.
[[nodiscard]] SceneRay ray_in_scene(const PosedSweep& posed, std::size_t ray);
/// Throws Error{kInput} when the file cannot be read.
[[nodiscard]] PosedSweep load_sweep(const Log& log, const SweepFrame& frame, const Eigen::Vector3d& origin);

/// Returns the view of the picture of `frame` at the training size.
[[nodiscard]] ImageView image_view(const Log& log,
                                   const ImageFrame& frame,
                                   const Eigen::Vector3d& origin,
                                   double image_scale);
/// Returns the picture and its view. Throws Error{kInput} when the file cannot be read.
[[nodiscard]] std::pair<Image, ImageView> load_view(const Log& log,
                                                    const ImageFrame& frame,
                                                    const Eigen::Vector3d& origin,
                                                    double image_scale);

[[nodiscard]] inline double middle_s(const ImageFrame& frame) {
  return 0.5 * (frame.time_start_s + frame.time_end_s);
}

/// Returns the frames that are not held out.
template <class Frame>
[[nodiscard]] std::vector<const Frame*> training_frames(const std::vector<Frame>& frames,
                                                        const HeldOutRule& rule) {
  std::vector<const Frame*> out;
  for (const std::size_t i : rule.training(frames)) out.push_back(&frames[i]);
  return out;
}

}  // namespace simuli
