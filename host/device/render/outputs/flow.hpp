#pragma once
// How what a camera sees moves on to another moment.
#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli {

/// Of each pixel's point at its median distance, which moves with the actor whose body it is of.
struct Flow {
  /// [height][width][3]: px to the right, px down to where the camera sees the point in the other shot, each
  /// at its own time of the shutters, and 1; the sky is 1000 km away. Zeros: no ray, or no image then, such as
  /// behind the camera. It may lie outside of the picture, or be hidden then.
  Image pixels;
  /// [height][width][3] m: where the point is then in the camera's axes then (x right, y down, z forward) less
  /// where it is now in the camera's axes now. Zeros where there is no pixel, and in the sky.
  Image points;
};

/// From a camera's frame of `scene` to the same camera in another shot, before or behind it. Waits.
/// Error{kUsage} for a frame rendered without FrameRequest::camera_median and actors, or of a LiDAR.
[[nodiscard]] Flow flow_of(const Frame& frame, const Scene& scene, const Shot& to);

}  // namespace simuli
