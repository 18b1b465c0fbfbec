#pragma once
#include <cstdint>

#include "host/device/render/frame/stages.hpp"

namespace simuli {

/// Behind blending: which particles a frame could do without.
class LargestWeightStage {
 public:
  LargestWeightStage(const Device& device, const Variant& variant);
  /// Raises largest[N] (bits of floats) to the largest weight of each particle in a ray of the frame.
  void run(const shared::FrameParams& frame,
           const RayBuffers& rays,
           const FrameBuffers& made,
           Buffer<std::uint32_t>& largest);

 private:
  std::size_t work_items_;
  Kernel largest_weight_;
};

}  // namespace simuli
