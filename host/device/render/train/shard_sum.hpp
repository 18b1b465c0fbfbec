#pragma once
// Sums gradients of several frames by a fixed tree, independent of the rank that computed them (METHOD section
// 10).
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

/// Sizes of shard sums.
struct ShardSizes {
  std::uint64_t particles = 0;  // N
  std::uint64_t stride = 0;
  std::uint64_t rows = 0;  // of a set's parameters, plus one of errors
  bool packs = false;  // sums are sent to other ranks
};
/// A sum over the particles with valid keys.
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

/// The sum of a step's gradients over its shards as a binary tree: a node covers shards [first, first + size),
/// with size a power of two and first a multiple of it, and is the sum of its halves; incomplete nodes are
/// added from the last one on. A node whose shards one rank owns can be sent as a whole, and the total has the
/// same bits however shards are distributed. Call start(), add() for each own shard in order, then total() with
/// the nodes of other ranks.
class ShardSum {
 public:
  /// A node sent to or received from another rank.
  struct Packed {
    std::uint64_t first = 0, size = 0;       // shards
    std::span<const std::uint32_t> columns;  // its visible particles, ascending
    std::span<const float> values;           // [rows][columns]
  };

  ShardSum(const Device& device, Precision precision);

  /// Starts without shards. With `errors` each shard also has a row of errors.
  void start(const ParticleBuffers& particles, bool errors);
  /// Returns a zeroed [stride] buffer for the errors of one frame.
  [[nodiscard]] RealBuffer& fresh_errors();
  /// Adds the next shard: share times the gradients [rows][stride] of particles whose key is not all ones, and
  /// the errors in fresh_errors().
  void add(std::size_t shard, const Buffer<std::uint32_t>& keys, const RealBuffer& grads, double share);

  /// Number of own nodes, before total().
  [[nodiscard]] std::size_t nodes() const { return nodes_.size(); }
  [[nodiscard]] Packed shards_of(std::size_t node) const {
    return {nodes_[node].first, nodes_[node].size, {}, {}};
  }
  /// Returns the visible particles of a node. Waits.
  [[nodiscard]] std::vector<std::uint32_t> columns_of(std::size_t node) const;
  [[nodiscard]] std::size_t rows() const { return rows_; }
  /// Copies the values of these columns to target[rows * columns]. Waits.
  void pack(std::size_t node, std::span<const std::uint32_t> columns, std::span<float> target);

  /// Joins the own nodes and `others`, in the order of shards, into sums(). Throws Error{kInternal} unless they
  /// cover all shards from 0 on once.
  void total(std::span<const Packed> others);
  /// The rows of the mean, and the keys of particles visible in any shard.
  [[nodiscard]] const RealBuffer& sums() const { return pool_[nodes_.at(0).place]->sum; }
  [[nodiscard]] const Buffer<std::uint32_t>& keys() const { return pool_[nodes_.at(0).place]->keys; }
  /// Adds the total errors to `sum` [N].
  void add_errors(RealBuffer& sum);

  /// Computes sum[i] += share from[i] for all elements of any matrix.
  void add_all(std::span<const float> from, double share, RealBuffer& sum);

  /// Number of sums on the device so far, and their maximum for a number of shards.
  [[nodiscard]] std::size_t places() const { return pool_.size(); }
  [[nodiscard]] static std::size_t most_nodes(std::size_t shards);

 private:
  struct Node {
    std::size_t first = 0, size = 0, place = 0;  // place: in pool_, or kElsewhere
    const Packed* packed = nullptr;  // received from another rank
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
  std::vector<Node> nodes_;  // sorted by shards
  std::size_t rows_ = 0, stride_ = 0, particles_ = 0;
  bool errors_ = false;
  Kernel add_, pack_, add_packed_, add_row_, add_all_;
};

}  // namespace simuli
