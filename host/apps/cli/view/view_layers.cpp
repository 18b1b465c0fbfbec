#include "host/apps/cli/view/view_layers.hpp"

#include <array>
#include <cstddef>
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
  constexpr float kLeast = 0.25F;  // least brightness, so that black objects are tinted
  // Colour-blind people can distinguish orange and blue.
  constexpr std::array<float, 3> kUnknown{1.0F, 0.42F, 0.0F}, kKnown{0.25F, 0.62F, 1.0F};
  LayerPicture out{frame.image()};
  const std::vector<float> known = support.of(frame, scene, copies);
  for (std::size_t i = 0; i < known.size(); ++i) {
    float* const pixel = out.image.data.data() + 3 * i;
    const float light = kLeast + (1.0F - kLeast) * (pixel[0] + pixel[1] + pixel[2]) / 3.0F;
    for (std::size_t c = 0; c < 3; ++c)
      pixel[c] = light * (kUnknown[c] + known[i] * (kKnown[c] - kUnknown[c]));
    out.support += static_cast<double>(known[i]) / static_cast<double>(known.size());
  }
  return out;
}

}  // namespace simuli::cli
