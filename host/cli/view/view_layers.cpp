#include "host/cli/view/view_layers.hpp"

#include <utility>

#include "host/base/error.hpp"
#include "host/cli/draw/depth_picture.hpp"

namespace simuli::cli {

LayerPicture layer_of(ViewLayer layer, const Frame& frame, const RecordedViews& recorded) {
  if (layer == ViewLayer::kColour) return {frame.image()};
  if (layer == ViewLayer::kOpacity) return {opacity_picture(frame)};
  if (layer == ViewLayer::kUnseen) {
    if (recorded.empty()) {
      throw_input_error(
          "scene", "cameras", "none that were carried along a path", "at least one, to mark unseen");
    }
    MarkedPicture marked = with_unseen_marked(frame, recorded);
    return {.image = std::move(marked.image), .unseen_share = marked.unseen_share};
  }
  DepthPicture depth = depth_picture(frame);
  return {std::move(depth.image), depth.near_m, depth.far_m};
}

}  // namespace simuli::cli
