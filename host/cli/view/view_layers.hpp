#pragma once
// What of a camera's frame the viewer shows.
#include "host/base/image.hpp"
#include "host/cli/view/view_request.hpp"
#include "host/render/scene/frame.hpp"

namespace simuli::cli {

struct LayerPicture {
  Image image;                       // [height][width][3]
  double near_m = 0.0, far_m = 0.0;  // ends of the scale of colours, of depth alone
};
/// Depth: colour_at() of the logarithm, from the power of 2 below the nearest to that above the farthest of
/// what all but one in 50 rays at either end meet; black where a ray goes on by more than a half. Waits.
[[nodiscard]] LayerPicture layer_of(ViewLayer layer, const Frame& frame);

}  // namespace simuli::cli
