#pragma once
// Depth and opacity of a camera's frame as pictures.
#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli::cli {

struct DepthPicture {
  Image image;                       // [height][width][3]
  double near_m = 0.0, far_m = 0.0;  // ends of the scale of colours; 0: nothing is met
};
/// colour_at() of the logarithm of distances, medians where the frame has them, else expected ones, from the
/// power of 2 below the nearest to that above the farthest of what all but one in 50 rays at either end meet;
/// black where a ray goes on by more than a half. Waits. Error{kUsage} of a LiDAR.
[[nodiscard]] DepthPicture depth_picture(const Frame& frame);

/// White where no light goes on, black where all does. Waits. Error{kUsage} of a LiDAR.
[[nodiscard]] Image opacity_picture(const Frame& frame);

}  // namespace simuli::cli
