#pragma once
// Gradients of the deformations of non-rigid actors.
#include <cstdint>
#include <vector>

#include "host/device/render/backward/gradient_buffers.hpp"
#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/render/frame/shapes_in_frame.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

/// dL/d(DeformationView) of an actor: [nodes][3] at the frame's start and end. Empty for a rigid actor.
struct DeformationGradient {
  std::vector<double> start, end;
};

struct DeformSizes {
  std::uint64_t nodes = 0;  // of all actors

  static constexpr std::uint32_t kChunks = 8;  // chunks of each actor's list, summed in parallel
};
struct DeformBuffers : BufferTable<DeformSizes> {
  using BufferTable::BufferTable;
  Words node_actor{*this, "node_actor", [](const DeformSizes& s) { return s.nodes; }};
  Words node_number{*this, "node_number", [](const DeformSizes& s) { return s.nodes; }};
  /// [nodes][chunks][3]
  Reals partial{
      *this, "deform_sums", [](const DeformSizes& s) { return 3 * DeformSizes::kChunks * s.nodes; }};
};

/// Runs after ProjectBackwardStage.
class DeformBackwardStage {
 public:
  DeformBackwardStage(const Device& device, Precision precision);
  /// Sums the node gradients, and converts param_grads from gradients by deformed positions to gradients by
  /// means. The order is fixed: the same frame gives the same bits.
  void run(const ShapesInFrame& shapes,
           const ParticleBuffers& particles,
           const FrameBuffers& made,
           RealBuffer& param_grads);
  /// Gradients [A] of the last run(). Waits.
  [[nodiscard]] std::vector<DeformationGradient> gradients(const ShapesInFrame& shapes) const;

 private:
  DeformBuffers buffers_;
  std::vector<std::uint32_t> actors_;  // [nodes]
  Kernel sums_, means_;
};

}  // namespace simuli
