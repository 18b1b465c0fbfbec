#pragma once
// Sums of the gradients of several frames, in one order whoever has computed them (METHOD section 10).
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/render/frame/particle_buffers.hpp"
#include "host/runtime/kernel.hpp"

namespace simuli {

/// What the sums of shards are sized by.
struct ShardSizes {
  std::uint64_t particles = 0;   // N
  std::uint64_t parameters = 0;  // of a set: rows times stride
  bool packs = false;            // shards go to other ranks
};
struct ShardBuffers : BufferTable<ShardSizes> {
  using BufferTable::BufferTable;
  Reals sums{*this, "shard_sums", [](const ShardSizes& s) { return s.parameters; }};
  Words keys{*this, "shard_keys", [](const ShardSizes& s) { return s.particles; }};
  Words order{*this, "shard_columns", [](const ShardSizes& s) { return s.particles; }};
  Reals errors{*this, "shard_errors", [](const ShardSizes& s) { return s.particles; }};
  Reals packed{*this, "shard_packed", [](const ShardSizes& s) { return s.packs ? s.parameters : 0; }};
};

/// The sum of a step's gradients over its shards: start(), then for each shard in turn set_columns() and an
/// add. Matrices are [rows][stride] as particles' parameters.
class ShardSum {
 public:
  ShardSum(const Device& device, Precision precision);

  /// Sums of 0, and no particle shown.
  void start(const ParticleBuffers& particles);
  /// The particles that a frame shows: those whose key is not all ones, in their order. Waits.
  [[nodiscard]] static std::vector<std::uint32_t> columns_of(const Buffer<std::uint32_t>& keys);
  /// The columns that pack() and add_*() are about from here on.
  void set_columns(std::span<const std::uint32_t> columns);

  /// [rows][columns] of a matrix of `rows`. Waits.
  [[nodiscard]] std::vector<float> pack(const RealBuffer& matrix, std::size_t rows);
  /// Adds share times the gradients of a shard to sums(); they stand in their matrix, or are pack()'s.
  void add(const RealBuffer& grads, double share);
  void add_packed(std::span<const float> grads, double share);
  /// The same of one row, to a sum of the caller's: errors[N].
  void add_errors(const RealBuffer& errors, RealBuffer& sum);
  void add_packed_errors(std::span<const float> errors, RealBuffer& sum);
  /// sum[i] += share from[i] of all, in matrices of any kind.
  void add_all(std::span<const float> from, double share, RealBuffer& sum);

  [[nodiscard]] const RealBuffer& sums() const { return buffers_.sums; }
  /// As a frame's that shows what any of the shards has shown.
  [[nodiscard]] const Buffer<std::uint32_t>& keys() const { return buffers_.keys; }
  /// [N] for the errors of one frame, zeros.
  [[nodiscard]] RealBuffer& fresh_errors();

 private:
  struct Matrix {
    std::size_t rows = 0, stride = 0;
    bool listed = true, packed = false;
  };
  void add(const Matrix& matrix, std::size_t count, const RealBuffer& from, double share, RealBuffer& sum);

  ShardBuffers buffers_;
  std::size_t rows_ = 0, stride_ = 0, particles_ = 0, columns_ = 0;
  Kernel pack_, add_, mark_;
};

}  // namespace simuli
