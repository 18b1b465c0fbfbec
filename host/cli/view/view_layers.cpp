#include "host/cli/view/view_layers.hpp"

#include <utility>

#include "host/cli/draw/depth_picture.hpp"

namespace simuli::cli {

LayerPicture layer_of(ViewLayer layer, const Frame& frame) {
  if (layer == ViewLayer::kColour) return {frame.image()};
  if (layer == ViewLayer::kOpacity) return {opacity_picture(frame)};
  DepthPicture depth = depth_picture(frame);
  return {std::move(depth.image), depth.near_m, depth.far_m};
}

}  // namespace simuli::cli
