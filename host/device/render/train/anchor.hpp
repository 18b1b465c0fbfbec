#pragma once
// The anchoring of one set's particles to another's (METHOD section 10).
#include <cstdint>
#include <vector>

#include "host/device/render/device/sort.hpp"
#include "host/device/render/frame/particle_buffers.hpp"

namespace simuli {

/// Distances of the particles seen in a frame to their anchors.
struct AnchorLoss {
  double distance_m = 0.0;  // sum
  double particles = 0.0;   // that have an anchor

  [[nodiscard]] double mean_m() const { return particles > 0.0 ? distance_m / particles : 0.0; }
};

/// What anchors are sized by.
struct AnchorSizes {
  std::uint64_t particles = 0;   // of the set that is anchored
  std::uint64_t neighbours = 0;  // of each
  std::uint64_t targets = 0;     // of the other set
  std::uint64_t bound_chunks = 0, loss_chunks = 0;

  static constexpr std::uint64_t kWidth = 16;  // points of a leaf, children of a node
  [[nodiscard]] std::uint64_t leaves() const { return (targets + kWidth - 1) / kWidth; }
  /// Nodes of the tree over the leaves, level by level up to the root.
  [[nodiscard]] std::vector<std::uint64_t> levels() const;
  [[nodiscard]] std::uint64_t nodes() const;
};
struct AnchorBuffers : BufferTable<AnchorSizes> {
  using BufferTable::BufferTable;
  /// [N][K], nearest first as they were when assigned; 0xffffffff: there are no more.
  Words candidates{*this, "candidates", [](const AnchorSizes& s) { return s.particles * s.neighbours; }};
  Words nearest{*this, "nearest", [](const AnchorSizes& s) { return s.particles; }};  // [N]
  Words order{*this, "morton_order", [](const AnchorSizes& s) { return s.targets; }};
  Words keys{*this, "morton_keys", [](const AnchorSizes& s) { return s.targets; }};
  Words ids{*this, "ids", [](const AnchorSizes& s) { return s.leaves() * AnchorSizes::kWidth; }};
  Reals points{*this, "points", [](const AnchorSizes& s) { return 3 * s.leaves() * AnchorSizes::kWidth; }};
  Reals boxes{*this, "boxes", [](const AnchorSizes& s) { return 6 * s.nodes() * AnchorSizes::kWidth; }};
  Reals parts{*this, "anchor_bounds", [](const AnchorSizes& s) { return 6 * s.bound_chunks; }};
  Reals frame{*this, "anchor_frame", [](const AnchorSizes&) { return std::uint64_t{4}; }};
  Reals sums{*this, "anchor_sums", [](const AnchorSizes& s) { return 2 * s.loss_chunks; }};
};

/// Holds for each particle of one set its K nearest of another. Exact: found by walking a tree of boxes over
/// the other set's Morton order, built on the device. Particles whose mean is not finite have no neighbours
/// and are nobody's. Neighbours are in one frame: both of the background, or both of one actor.
class AnchorStage {
 public:
  /// `neighbours`: K, at least 1. `work_items` search for each particle: 1, or 16 with local memory; 0: as
  /// suits the device. Tests run the GPU's way on CPUs.
  AnchorStage(const Device& device,
              Precision precision,
              std::uint32_t neighbours,
              std::size_t work_items = 0);

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

  /// After the particles of the anchored set, or the targets, went to other places: place i has now what was
  /// at order[i]. Waits.
  void follow_set(const std::vector<Eigen::Index>& order);
  void follow_targets(const std::vector<Eigen::Index>& order);

  [[nodiscard]] std::uint32_t neighbours() const { return neighbours_; }
  /// [N][K], nearest first as they were when assigned; 0xffffffff: there are no more.
  [[nodiscard]] Buffer<std::uint32_t>& candidates() { return buffers_.candidates; }
  [[nodiscard]] Buffer<std::uint32_t>& nearest() { return buffers_.nearest; }  // [N]

 private:
  /// Targets in Morton order, cut into leaves of a tree of boxes.
  void build_tree(const ParticleBuffers& targets);
  void order_by_place(const ParticleBuffers& targets);
  void box_leaves(const ParticleBuffers& targets);
  [[nodiscard]] AnchorSizes sizes() const;

  Device device_;
  std::size_t work_items_;
  std::uint32_t neighbours_;
  std::uint32_t particles_ = 0, targets_ = 0;  // when last assigned
  SortStage sort_;
  AnchorBuffers buffers_;
  Kernel bounds_, keys_, leaves_, nodes_, search_, loss_;
};

}  // namespace simuli
