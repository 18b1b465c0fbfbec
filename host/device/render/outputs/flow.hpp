#pragma once
// Optical flow and scene flow of a camera's frame to another time.
#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli {

/// Flow of each pixel's point at its median distance, which moves with its actor.
struct Flow {
  /// [height][width][3]: px to the right, px down to the point's image in the other shot, each at its own
  /// shutter time, and validity 1; sky is at 1000 km. Zeros without a ray or an image then, for instance behind
  /// the camera. The image may be outside the picture or occluded.
  Image pixels;
  /// [height][width][3] m: the point in the camera axes of the other shot (x right, y down, z forward) minus
  /// the point in the current camera axes. Zeros without a point, and in the sky.
  Image points;
};

/// Computes flow from a camera's frame of `scene` to the same camera in another shot, earlier or later. Waits.
/// Throws Error{kUsage} for a frame rendered without FrameRequest::camera_median and actors, or of a LiDAR.
[[nodiscard]] Flow flow_of(const Frame& frame, const Scene& scene, const Shot& to);

}  // namespace simuli
