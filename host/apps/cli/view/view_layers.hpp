#pragma once
// Layers of a camera's frame in the viewer.
#include "host/apps/cli/draw/unseen.hpp"
#include "host/apps/cli/view/view_request.hpp"
#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"
#include "host/device/support/support.hpp"

namespace simuli::cli {

struct LayerPicture {
  Image image;                       // [height][width][3]
  double near_m = 0.0, far_m = 0.0;  // ends of the colour scale; only for depth
  double unseen_share = 0.0;         // share of the pixels; only if unseen ones are marked
  double support = 0.0;              // mean over the pixels; only for the support layer
};
/// As in host/apps/cli/draw/depth_picture.hpp and unseen.hpp. Waits. Throws Error{kInput} for unseen pixels of
/// a scene without recorded cameras.
[[nodiscard]] LayerPicture layer_of(ViewLayer layer, const Frame& frame, const RecordedViews& recorded);
/// Returns ViewLayer::kSupport: the picture's brightness, tinted orange for low and blue for high support.
/// Waits.
[[nodiscard]] LayerPicture support_layer(const Frame& frame,
                                         const Scene& scene,
                                         const ActorCopies& copies,
                                         SupportOnDevice& support);

}  // namespace simuli::cli
