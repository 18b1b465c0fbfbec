#pragma once
// What of a camera's frame the viewer shows.
#include "host/apps/cli/draw/unseen.hpp"
#include "host/apps/cli/view/view_request.hpp"
#include "host/core/base/image.hpp"
#include "host/device/render/scene/frame.hpp"
#include "host/device/support/support.hpp"

namespace simuli::cli {

struct LayerPicture {
  Image image;                       // [height][width][3]
  double near_m = 0.0, far_m = 0.0;  // ends of the scale of colours, of depth alone
  double unseen_share = 0.0;         // of the pixels, where unseen ones are marked
  double support = 0.0;              // mean of the pixels, where it is shown
};
/// As in host/apps/cli/draw/depth_picture.hpp and unseen.hpp. Waits. Error{kInput} for unseen pixels of a scene
/// that no camera was carried through.
[[nodiscard]] LayerPicture layer_of(ViewLayer layer, const Frame& frame, const RecordedViews& recorded);
/// ViewLayer::kSupport: the picture's own light, orange where it is not known, blue where it is. Waits.
[[nodiscard]] LayerPicture support_layer(const Frame& frame,
                                         const Scene& scene,
                                         const ActorCopies& copies,
                                         SupportOnDevice& support);

}  // namespace simuli::cli
