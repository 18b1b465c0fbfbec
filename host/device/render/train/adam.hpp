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

/// Gradients of means over many rays are tiny: what damps none of them.
inline constexpr double kAdamEpsilon = 1e-15;

/// Of each row of parameters.
struct AdamRows {
  std::vector<double> rate;
  /// A parameter whose gradients are of this size moves at half its rate, one with much smaller ones hardly
  /// at all. As many as rates; empty: kAdamEpsilon each.
  std::vector<double> epsilon = {};
};

/// Adam on a parameter matrix: of one set, or of anything that every step moves as a whole.
class AdamStage {
 public:
  AdamStage(const Device& device, const ParticleBuffers& particles);
  AdamStage(const Device& device, Precision precision, std::size_t parameters);
  /// One step with rows[param_rows] on the particles that the frame of `keys` (FrameBuffers) did not cull;
  /// counts iterations itself.
  void run(ParticleBuffers& particles,
           const RealBuffer& grads,
           const Buffer<std::uint32_t>& keys,
           const AdamRows& rows);
  /// Step number `step` (from 1) with one rate on params[first, first + count), a multiple of kStep, by the first
  /// of `grads`.
  static constexpr std::size_t kStep = 16;
  void run_dense(RealBuffer& params,
                 const RealBuffer& grads,
                 std::size_t first,
                 std::size_t count,
                 double rate,
                 std::uint64_t step,
                 double epsilon = kAdamEpsilon);
  /// Gradient entries so far that were not finite and moved nothing. Waits.
  [[nodiscard]] std::uint32_t rejected() const { return buffers_.rejected.read_back(); }
  [[nodiscard]] Buffer<std::uint32_t>& rejections() { return buffers_.rejected; }
  [[nodiscard]] std::uint64_t& iteration() { return iteration_; }  // steps done
  /// The moments [param_rows][stride], for whoever renumbers or stores them.
  [[nodiscard]] RealBuffer& first_moment() { return buffers_.first_moment; }
  [[nodiscard]] RealBuffer& second_moment() { return buffers_.second_moment; }

 private:
  struct Matrix {
    std::uint32_t columns, stride, first;
    bool dense;  // all columns have a gradient: no keys are read
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
