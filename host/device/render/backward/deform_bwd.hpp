#pragma once
// Gradients of the shapes of actors that are not rigid.
#include <cstdint>
#include <vector>

#include "host/device/render/backward/gradient_buffers.hpp"
#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/render/frame/shapes_in_frame.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

/// dL/d(DeformationView) of an actor: [nodes][3] at the frame's start and end. Empty: it has no shape.
struct DeformationGradient {
  std::vector<double> start, end;
};

struct DeformSizes {
  std::uint64_t nodes = 0;  // of all actors

  static constexpr std::uint32_t kChunks = 8;  // of each actor's list, summed side by side
};
struct DeformBuffers : BufferTable<DeformSizes> {
  using BufferTable::BufferTable;
  Words node_actor{*this, "node_actor", [](const DeformSizes& s) { return s.nodes; }};
  Words node_number{*this, "node_number", [](const DeformSizes& s) { return s.nodes; }};
  /// [nodes][chunks][3]
  Reals partial{
      *this, "deform_sums", [](const DeformSizes& s) { return 3 * DeformSizes::kChunks * s.nodes; }};
};

/// Behind ProjectBackwardStage.
class DeformBackwardStage {
 public:
  DeformBackwardStage(const Device& device, Precision precision);
  /// Sums of the nodes' gradients; and param_grads, which were by where the particles are, become those by
  /// their means. In one fixed order: the same frame gives the same bits.
  void run(const ShapesInFrame& shapes,
           const ParticleBuffers& particles,
           const FrameBuffers& made,
           RealBuffer& param_grads);
  /// Of the last run(), [A]. Waits.
  [[nodiscard]] std::vector<DeformationGradient> gradients(const ShapesInFrame& shapes) const;

 private:
  DeformBuffers buffers_;
  std::vector<std::uint32_t> actors_;  // [nodes]
  Kernel sums_, means_;
};

}  // namespace simuli
