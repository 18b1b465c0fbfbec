#pragma once
// Marks parts of a picture that no recorded camera has covered.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli::cli {

/// Camera poses of the recording of a scene: at the recorded frames, or at all ego poses if the scene does
/// not store frame times.
class RecordedViews {
 public:
  /// `file` must outlive this object and the results of around().
  explicit RecordedViews(const SceneFile& file);

  /// Whether the scene has no camera or no trajectory.
  [[nodiscard]] bool empty() const { return views_.empty(); }
  /// Returns a selection for a point (m, world): the kNearest nearest views of each camera and as many of its
  /// other views, evenly selected.
  [[nodiscard]] RecordedViews around(const Eigen::Vector3d& p_world) const;
  static constexpr std::size_t kNearest = 30;
  /// Whether a point (m, world) projects into one of the pictures; occlusion is ignored.
  [[nodiscard]] bool has(const Eigen::Vector3d& p_world) const;

 private:
  RecordedViews() = default;
  struct View {
    const Camera* camera;
    Pose camera_from_world;
    Eigen::Vector3d p_world;  // position of the camera, m
  };
  std::vector<View> views_;  // by camera
  mutable std::size_t last_ =
      0;  // view that contained the last point; neighbours are mostly in the same view
};

/// A camera picture with hatched, darkened areas that no recorded picture covers. Tested is the point at the
/// mean distance, or at the median if the frame has it (FrameRequest::camera_median) and it is nearer; with a
/// transmittance above one half the direction. The resolution is one block of kUnseenBlock_px. Pixels without
/// a ray are unchanged. Waits for the frame. Throws Error{kUsage} for a LiDAR.
struct MarkedPicture {
  Image image;
  double unseen_share = 0.0;  // share of the pixels with a ray
};
[[nodiscard]] MarkedPicture with_unseen_marked(const Frame& frame, const RecordedViews& views);
inline constexpr int kUnseenBlock_px = 4;

}  // namespace simuli::cli
