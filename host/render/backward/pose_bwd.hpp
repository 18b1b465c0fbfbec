#pragma once
#include "host/render/backward/gradient_buffers.hpp"
#include "host/render/backward/pose_gradient.hpp"
#include "host/render/frame/stages.hpp"

namespace simuli {

struct PoseSizes {
  std::uint64_t ray_chunks = 0;
  std::uint64_t particle_chunks = 0;
};
struct PoseBuffers : BufferTable<PoseSizes> {
  using BufferTable::BufferTable;
  Reals ray_sums{*this, "torques", [](const PoseSizes& s) { return 3 * s.ray_chunks; }};
  Reals particle_sums{*this, "forces", [](const PoseSizes& s) { return 3 * s.particle_chunks; }};
};

/// Behind a backward pass with ray gradients: that of the sensor's pose.
class PoseStage {
 public:
  PoseStage(const Device& device, const Variant& variant);
  /// From ray_grads and the gradients of the means. Waits.
  PoseGradient run(const shared::FrameParams& frame,
                   const RayBuffers& rays,
                   const FrameConstants& constants,
                   const Projected& projected,
                   const GradientBuffers& gradients,
                   const RealBuffer& param_grads);

 private:
  Device device_;
  PoseBuffers buffers_;
  Kernel rays_, particles_;
};

}  // namespace simuli
