#pragma once
#include <cstdint>

#include "host/device/render/frame/stages.hpp"

namespace simuli {

/// Finds particles that a frame does not need, after blending.
class LargestWeightStage {
 public:
  LargestWeightStage(const Device& device, const Variant& variant);
  /// Raises largest[N] (float bits) to each particle's largest weight in a ray of the frame.
  void run(const shared::FrameParams& frame,
           const RayBuffers& rays,
           const FrameBuffers& made,
           Buffer<std::uint32_t>& largest);

 private:
  std::size_t work_items_;
  Kernel largest_weight_;
};

}  // namespace simuli
