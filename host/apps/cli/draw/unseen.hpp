#pragma once
// What a picture shows that no recorded camera faced.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// Where the cameras were, and looked, that a scene was made of: at their recorded frames, or all along the
/// path where the scene doesn't say when these were.
class RecordedViews {
 public:
  /// `file` must outlive this and what around() makes of it.
  explicit RecordedViews(const SceneFile& file);

  /// A scene without cameras, or without a path: nothing can be told.
  [[nodiscard]] bool empty() const { return views_.empty(); }
  /// Those that tell most of what is seen from a point (m, world): the kNearest views of each camera, and as
  /// many of its others, evenly spread.
  [[nodiscard]] RecordedViews around(const Eigen::Vector3d& p_world) const;
  static constexpr std::size_t kNearest = 30;
  /// Whether a point (m, world) falls into one of the pictures, whatever stands before it.
  [[nodiscard]] bool has(const Eigen::Vector3d& p_world) const;

 private:
  RecordedViews() = default;
  struct View {
    const Camera* camera;
    Pose camera_from_world;
    Eigen::Vector3d p_world;  // of the camera, m
  };
  std::vector<View> views_;       // by camera
  mutable std::size_t last_ = 0;  // that had a point: its neighbours mostly have theirs there, too
};

/// A camera's picture, hatched and darkened where nothing recorded is: where what a pixel shows, or its
/// direction where the light goes on by more than a half, was in no recorded picture. What it shows is at the
/// mean distance, or at the median where the frame has it (FrameRequest::camera_median) and it is nearer.
/// Told for blocks of kUnseenBlock_px. Pixels without a ray stay as they are. Waits. Error{kUsage} of a
/// LiDAR.
struct MarkedPicture {
  Image image;
  double unseen_share = 0.0;  // of the pixels that have a ray
};
[[nodiscard]] MarkedPicture with_unseen_marked(const Frame& frame, const RecordedViews& views);
inline constexpr int kUnseenBlock_px = 4;

}  // namespace simuli::cli
