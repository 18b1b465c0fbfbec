#pragma once
// Pictures of depth and opacity of a camera frame.
#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli::cli {

struct DepthPicture {
  Image image;                       // [height][width][3]
  double near_m = 0.0, far_m = 0.0;  // range of the colour scale; 0: no ray has a depth
};
/// Returns colour_at() of the logarithm of the distances: the medians if the frame has them, else the
/// expected distances. The scale covers all but one in 50 distances at either end, rounded outwards to powers
/// of 2. Rays with a transmittance above one half are black. Waits for the frame. Throws Error{kUsage} for a
/// LiDAR.
[[nodiscard]] DepthPicture depth_picture(const Frame& frame);

/// Returns white for transmittance 0 and black for 1. Waits for the frame. Throws Error{kUsage} for a LiDAR.
[[nodiscard]] Image opacity_picture(const Frame& frame);

}  // namespace simuli::cli
