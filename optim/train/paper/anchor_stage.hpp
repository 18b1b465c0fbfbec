#pragma once
// Anchoring of one set's particles to another set (METHOD section 10).
#include <cstdint>
#include <vector>

#include "host/device/render/device/sort.hpp"
#include "host/device/render/frame/particle_buffers.hpp"

namespace simuli {

// In trainings:
constexpr std::uint32_t kAnchorNeighbours = 50;  // candidates of each particle
constexpr double kAnchorReach_m = 2.0;  // particles farther from all LiDAR particles (sky) are not anchored

/// Distances of visible particles to their anchors.
struct AnchorLoss {
  double distance_m = 0.0;  // sum
  double particles = 0.0;   // particles with an anchor

  [[nodiscard]] double mean_m() const { return particles > 0.0 ? distance_m / particles : 0.0; }
};

/// Sizes of anchors.
struct AnchorSizes {
  std::uint64_t particles = 0;   // of the anchored set
  std::uint64_t neighbours = 0;  // per particle
  std::uint64_t targets = 0;     // of the other set
  std::uint64_t bound_chunks = 0, loss_chunks = 0;

  static constexpr std::uint64_t kWidth = 16;  // points per leaf, children per node
  [[nodiscard]] std::uint64_t leaves() const { return (targets + kWidth - 1) / kWidth; }
  /// Nodes of the tree above the leaves, level by level up to the root.
  [[nodiscard]] std::vector<std::uint64_t> levels() const;
  [[nodiscard]] std::uint64_t nodes() const;
};
struct AnchorBuffers : BufferTable<AnchorSizes> {
  using BufferTable::BufferTable;
  /// [N][K], nearest first at assignment; 0xffffffff: none.
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

/// The K nearest neighbours of each particle of one set in another set. Exact: searches a tree of boxes over
/// the other set's Morton order, built on the device. Particles with a non-finite mean have no neighbours and
/// are no neighbours. Neighbours share a frame: the background's, or one actor's.
class AnchorStage {
 public:
  /// `neighbours`: K, at least 1. `work_items` per search: 1, or 16 with local memory; 0: chosen for the
  /// device. Tests run the GPU configuration on CPUs.
  AnchorStage(const Device& device,
              Precision precision,
              std::uint32_t neighbours,
              std::size_t work_items = 0);

  /// Finds the neighbours of all particles of `set` among `targets` within reach_m (infinity: any).
  void assign(const ParticleBuffers& set, const ParticleBuffers& targets, double reach_m);
  /// Whether assign() was called for as many particles as `set` has.
  [[nodiscard]] bool is_assigned_for(const ParticleBuffers& set) const;

  /// Adds d(weight x sum of distances)/d(means) of the particles visible in the frame of `keys` to `grads`:
  /// distances to their nearest candidate, selected again if `choose`, else the previous one. Particles may
  /// have moved since assign(), but not been reordered.
  void add_gradient(const ParticleBuffers& set,
                    const ParticleBuffers& targets,
                    const Buffer<std::uint32_t>& keys,
                    double weight,
                    bool choose,
                    RealBuffer& grads);
  /// Result of the last add_gradient(). Waits.
  [[nodiscard]] AnchorLoss loss() const;

  /// Reorders after the anchored set or the targets were reordered: index i now has the former order[i]. Waits.
  void follow_set(const std::vector<Eigen::Index>& order);
  void follow_targets(const std::vector<Eigen::Index>& order);

  [[nodiscard]] std::uint32_t neighbours() const { return neighbours_; }
  /// [N][K], nearest first at assignment; 0xffffffff: none.
  [[nodiscard]] Buffer<std::uint32_t>& candidates() { return buffers_.candidates; }
  [[nodiscard]] Buffer<std::uint32_t>& nearest() { return buffers_.nearest; }  // [N]

 private:
  /// Builds the tree over the targets in Morton order.
  void build_tree(const ParticleBuffers& targets);
  void order_by_place(const ParticleBuffers& targets);
  void box_leaves(const ParticleBuffers& targets);
  [[nodiscard]] AnchorSizes sizes() const;

  Device device_;
  std::size_t work_items_;
  std::uint32_t neighbours_;
  std::uint32_t particles_ = 0, targets_ = 0;  // at the last assign()
  SortStage sort_;
  AnchorBuffers buffers_;
  Kernel bounds_, keys_, leaves_, nodes_, search_, loss_;
};

}  // namespace simuli
