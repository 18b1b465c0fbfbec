#pragma once
// Sums of the gradients of several frames, by one tree whoever has computed them (METHOD section 10).
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

/// What the sums of shards are sized by.
struct ShardSizes {
  std::uint64_t particles = 0;  // N
  std::uint64_t stride = 0;
  std::uint64_t rows = 0;  // of a set's parameters, and one of errors
  bool packs = false;      // sums go to other ranks
};
/// One sum: of what its keys show.
struct ShardNodeBuffers : BufferTable<ShardSizes> {
  using BufferTable::BufferTable;
  Reals sum{*this, "shard_sums", [](const ShardSizes& s) { return s.rows * s.stride; }};
  Words keys{*this, "shard_keys", [](const ShardSizes& s) { return s.particles; }};
};
struct ShardBuffers : BufferTable<ShardSizes> {
  using BufferTable::BufferTable;
  Words order{*this, "shard_columns", [](const ShardSizes& s) { return s.particles; }};
  Reals errors{*this, "shard_errors", [](const ShardSizes& s) { return s.stride; }};
  Reals packed{*this, "shard_packed", [](const ShardSizes& s) { return s.packs ? s.rows * s.stride : 0; }};
};

/// The sum of a step's gradients over its shards. It is that of a binary tree: shards [first, first + size),
/// size a power of two and first a multiple of it, are a node, the sum of its halves; nodes that nothing
/// completes are added from the last one on. A node that one rank has all shards of can go to others as a
/// whole, and the bits of the total are the same however the shards are shared. start(), add() each own shard
/// in its order, then total() with what others have.
class ShardSum {
 public:
  /// A node for other ranks, or of another rank.
  struct Packed {
    std::uint64_t first = 0, size = 0;       // shards
    std::span<const std::uint32_t> columns;  // the particles that it shows, in their order
    std::span<const float> values;           // [rows][columns]
  };

  ShardSum(const Device& device, Precision precision);

  /// No shard yet. With `errors` each also has a row of them.
  void start(const ParticleBuffers& particles, bool errors);
  /// [stride] for the errors of one frame, zeros.
  [[nodiscard]] RealBuffer& fresh_errors();
  /// Shard `shard`, behind those before it: share times the gradients [rows][stride] of the particles whose
  /// key is not all ones, and the errors in fresh_errors().
  void add(std::size_t shard, const Buffer<std::uint32_t>& keys, const RealBuffer& grads, double share);

  /// The own nodes, before total().
  [[nodiscard]] std::size_t nodes() const { return nodes_.size(); }
  [[nodiscard]] Packed shards_of(std::size_t node) const {
    return {nodes_[node].first, nodes_[node].size, {}, {}};
  }
  /// Waits.
  [[nodiscard]] std::vector<std::uint32_t> columns_of(std::size_t node) const;
  [[nodiscard]] std::size_t rows() const { return rows_; }
  /// Its values of these columns, into target[rows * columns]. Waits.
  void pack(std::size_t node, std::span<const std::uint32_t> columns, std::span<float> target);

  /// Joins the own nodes and `others`, in the order of shards, into sums(). Error{kInternal} for others than
  /// make all shards from 0 on, each once.
  void total(std::span<const Packed> others);
  /// The mean's rows, and as a frame's keys: what any of the shards has shown.
  [[nodiscard]] const RealBuffer& sums() const { return pool_[nodes_.at(0).place]->sum; }
  [[nodiscard]] const Buffer<std::uint32_t>& keys() const { return pool_[nodes_.at(0).place]->keys; }
  /// Adds the total's errors to `sum` [N].
  void add_errors(RealBuffer& sum);

  /// sum[i] += share from[i] of all, in matrices of any kind.
  void add_all(std::span<const float> from, double share, RealBuffer& sum);

  /// Sums on the device so far, and how many these are at most for a number of shards.
  [[nodiscard]] std::size_t places() const { return pool_.size(); }
  [[nodiscard]] static std::size_t most_nodes(std::size_t shards);

 private:
  struct Node {
    std::size_t first = 0, size = 0, place = 0;  // place: in pool_, or kElsewhere
    const Packed* packed = nullptr;              // another rank's
  };
  static constexpr std::size_t kElsewhere = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t free_place();
  void push(const Node& node);
  void join_last();
  void add_to(std::size_t place,
              const Buffer<std::uint32_t>& keys,
              const RealBuffer& from,
              std::size_t rows,
              std::size_t first_row,
              bool mark,
              double share);
  void add_to(std::size_t place, const Packed& packed);

  int lanes_;
  ShardBuffers buffers_;
  std::vector<std::unique_ptr<ShardNodeBuffers>> pool_;
  std::vector<std::size_t> free_;
  std::vector<Node> nodes_;  // by their shards
  std::size_t rows_ = 0, stride_ = 0, particles_ = 0;
  bool errors_ = false;
  Kernel add_, pack_, add_packed_, add_row_, add_all_;
};

}  // namespace simuli
