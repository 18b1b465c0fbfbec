#pragma once
// The anchoring of one set's particles to another's (METHOD section 10).
#include <cstdint>

#include "host/render/frame/stages.hpp"

namespace simuli {

/// Distances of the particles seen in a frame to their anchors.
struct AnchorLoss {
  double distance_m = 0.0;  // sum
  double particles = 0.0;   // that have an anchor

  [[nodiscard]] double mean_m() const { return particles > 0.0 ? distance_m / particles : 0.0; }
};

/// Holds for each particle of one set its K nearest of another. Exact: found by walking a tree of boxes over
/// the other set's Morton order, built on the device. Particles whose mean is not finite have no neighbours
/// and are nobody's. Neighbours are in one frame: both of the background, or both of one actor.
class AnchorStage {
 public:
  /// `neighbours`: K, at least 1.
  AnchorStage(const Device& device, Precision precision, std::uint32_t neighbours);

  /// Finds the neighbours of all particles of `set` among `targets`, nearer than reach_m (infinity: any).
  void assign(const ParticleBuffers& set, const ParticleBuffers& targets, double reach_m);
  /// Whether assign() has been called for as many particles as `set` has.
  [[nodiscard]] bool is_assigned_for(const ParticleBuffers& set) const;

  /// Adds d(weight x sum of distances)/d(means) of the particles seen in the frame of `keys` to `grads`: to
  /// their nearest candidate, found anew when `choose`, else that of the last time. Sets may have moved since
  /// assign(), but not been renumbered.
  void add_gradient(const ParticleBuffers& set,
                    const ParticleBuffers& targets,
                    const Buffer<std::uint32_t>& keys,
                    double weight,
                    bool choose,
                    RealBuffer& grads);
  /// Of the last add_gradient(). Waits.
  [[nodiscard]] AnchorLoss loss() const;

  [[nodiscard]] std::uint32_t neighbours() const { return neighbours_; }
  /// [N][K], nearest first as they were when assigned; 0xffffffff: there are no more.
  [[nodiscard]] Buffer<std::uint32_t>& candidates() { return candidates_; }
  [[nodiscard]] Buffer<std::uint32_t>& nearest() { return nearest_; }  // [N]

 private:
  Device device_;
  std::uint32_t neighbours_;
  ScanStage scan_;
  SortStage sort_;
  Buffer<std::uint32_t> candidates_, nearest_;
  Buffer<std::uint32_t> order_, keys_, order_scratch_, key_scratch_, ids_;
  RealBuffer bounds_, frame_, points_, boxes_, sums_;
  Kernel<BufRealConst, std::uint32_t, std::uint32_t, std::uint32_t, BufReal> bounds_kernel_;
  Kernel<BufRealConst,
         std::uint32_t,
         std::uint32_t,
         BufRealConst,
         std::uint32_t,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>>
      keys_kernel_;
  Kernel<BufRealConst,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         BufReal,
         Buf<std::uint32_t>,
         BufReal,
         std::uint32_t>
      leaves_kernel_;
  Kernel<BufReal, std::uint32_t, std::uint32_t, std::uint32_t> nodes_kernel_;
  Kernel<BufRealConst,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         RealScalar,
         BufRealConst,
         BufRealConst,
         Buf<const std::uint32_t>,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>>
      search_kernel_;
  Kernel<std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         BufRealConst,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         BufRealConst,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         std::uint32_t,
         RealScalar,
         Buf<std::uint32_t>,
         BufReal,
         BufReal>
      loss_kernel_;
};

}  // namespace simuli
