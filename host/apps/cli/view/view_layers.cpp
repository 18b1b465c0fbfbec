#include "host/apps/cli/view/view_layers.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "host/apps/cli/draw/depth_picture.hpp"
#include "host/core/base/error.hpp"

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

LayerPicture support_layer(const Frame& frame,
                           const Scene& scene,
                           const ActorCopies& copies,
                           SupportOnDevice& support) {
  constexpr float kLeast = 0.25F;  // light, so that black things have a colour
  LayerPicture out{frame.image()};
  const std::vector<float> known = support.of(frame, scene, copies);
  for (std::size_t i = 0; i < known.size(); ++i) {
    float* const pixel = out.image.data.data() + 3 * i;
    const float light = kLeast + (1.0F - kLeast) * (pixel[0] + pixel[1] + pixel[2]) / 3.0F;
    pixel[0] = light * std::clamp(2.0F - 2.0F * known[i], 0.0F, 1.0F);
    pixel[1] = light * std::clamp(2.0F * known[i], 0.0F, 1.0F);
    pixel[2] = 0.0F;
    out.support += static_cast<double>(known[i]) / static_cast<double>(known.size());
  }
  return out;
}

}  // namespace simuli::cli
