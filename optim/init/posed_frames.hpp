#pragma once
// Frames of a log in the scene: what was recorded beside the poses it was recorded from.
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

/// A sweep with the poses at its start and end. `lidar` is the log's.
struct PosedSweep {
  const LidarModel& lidar;
  Sweep sweep;
  Pose scene_from_lidar_start;
  Pose scene_from_lidar_end;
};
struct SceneRay {
  Eigen::Vector3d origin, direction;  // m, unit
};
/// A ray (row-major) where it was when it fired.
[[nodiscard]] SceneRay ray_in_scene(const PosedSweep& posed, std::size_t ray);
/// Error{kInput} when it can't be read.
[[nodiscard]] PosedSweep load_sweep(const Log& log, const SweepFrame& frame, const Eigen::Vector3d& origin);

/// From where the picture of `frame` was taken, at the training size.
[[nodiscard]] ImageView image_view(const Log& log,
                                   const ImageFrame& frame,
                                   const Eigen::Vector3d& origin,
                                   double image_scale);
/// The picture itself beside it. Error{kInput} when it can't be read.
[[nodiscard]] std::pair<Image, ImageView> load_view(const Log& log,
                                                    const ImageFrame& frame,
                                                    const Eigen::Vector3d& origin,
                                                    double image_scale);

[[nodiscard]] inline double middle_s(const ImageFrame& frame) {
  return 0.5 * (frame.time_start_s + frame.time_end_s);
}

/// Those that are not held out.
template <class Frame>
[[nodiscard]] std::vector<const Frame*> training_frames(const std::vector<Frame>& frames,
                                                        const HeldOutRule& rule) {
  std::vector<const Frame*> out;
  for (const std::size_t i : rule.training(frames)) out.push_back(&frames[i]);
  return out;
}

}  // namespace simuli
