#pragma once
#include <cstdint>
#include <vector>

#include "host/device/render/frame/particle_buffers.hpp"
#include "host/device/runtime/kernel.hpp"

namespace simuli {

struct AdamSizes {
  std::uint64_t parameters = 0;
  std::uint64_t rates = 1;
};
struct AdamBuffers : BufferTable<AdamSizes> {
  using BufferTable::BufferTable;
  Reals rate{*this, "rate", [](const AdamSizes& s) { return s.rates; }};
  Reals epsilon{*this, "epsilon", [](const AdamSizes& s) { return s.rates; }};
  Reals first_moment{*this, "first_moment", [](const AdamSizes& s) { return s.parameters; }};
  Reals second_moment{*this, "second_moment", [](const AdamSizes& s) { return s.parameters; }};
  Words rejected{*this, "rejected", [](const AdamSizes&) { return std::uint64_t{1}; }};
};

/// Gradients of means over many rays are tiny: an epsilon that damps none of them.
inline constexpr double kAdamEpsilon = 1e-15;

/// Rates and epsilons by parameter row.
struct AdamRows {
  std::vector<double> rate;
  /// A parameter with gradients of this size moves at half its rate, with much smaller gradients hardly at all.
  /// As many as rates; empty: kAdamEpsilon each.
  std::vector<double> epsilon = {};
};

/// Adam on a parameter matrix: of a set, or of parameters that all take part in every step.
class AdamStage {
 public:
  AdamStage(const Device& device, const ParticleBuffers& particles);
  AdamStage(const Device& device, Precision precision, std::size_t parameters);
  /// Takes a step with rows[param_rows] on the particles that the frame of `keys` (FrameBuffers) did not cull;
  /// counts the iterations.
  void run(ParticleBuffers& particles,
           const RealBuffer& grads,
           const Buffer<std::uint32_t>& keys,
           const AdamRows& rows);
  /// Takes step number `step` (from 1) with one rate on params[first, first + count), a multiple of kStep, with
  /// gradients from the start of `grads`.
  static constexpr std::size_t kStep = 16;
  void run_dense(RealBuffer& params,
                 const RealBuffer& grads,
                 std::size_t first,
                 std::size_t count,
                 double rate,
                 std::uint64_t step,
                 double epsilon = kAdamEpsilon);
  /// Number of non-finite gradient entries, which changed nothing. Waits.
  [[nodiscard]] std::uint32_t rejected() const { return buffers_.rejected.read_back(); }
  [[nodiscard]] Buffer<std::uint32_t>& rejections() { return buffers_.rejected; }
  [[nodiscard]] std::uint64_t& iteration() { return iteration_; }  // completed steps
  /// The moments [param_rows][stride], for reordering and checkpoints.
  [[nodiscard]] RealBuffer& first_moment() { return buffers_.first_moment; }
  [[nodiscard]] RealBuffer& second_moment() { return buffers_.second_moment; }

 private:
  struct Matrix {
    std::uint32_t columns, stride, first;
    bool dense;  // all columns have a gradient: no keys
  };
  void launch(const Matrix& matrix,
              const Buffer<std::uint32_t>& keys,
              const AdamRows& rows,
              std::uint64_t step,
              const RealBuffer& grads,
              RealBuffer& params);
  int lanes_;
  std::uint64_t iteration_ = 0;
  AdamBuffers buffers_;
  Kernel adam_;
};

}  // namespace simuli
