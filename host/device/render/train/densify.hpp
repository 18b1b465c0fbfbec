#pragma once
// Relocation and growth of a particle set by reconstruction error (METHOD section 11).
#include <array>
#include <cstdint>
#include <span>

#include "host/device/render/backward/gradient_buffers.hpp"
#include "host/device/render/device/scan.hpp"
#include "host/device/render/frame/particle_buffers.hpp"

namespace simuli {

/// What random numbers depend on, beside the particle.
struct RandomKey {
  std::uint64_t seed = 0;
  std::uint32_t iteration = 0;
  std::uint32_t set = 0;  // index of the set in the scene
};

struct DensifyCounts {
  std::uint32_t relocated = 0;
  std::uint32_t grown = 0;
};

/// Sizes of relocation.
struct DensifySizes {
  std::uint64_t particles = 0;
  std::uint64_t targets = 0;  // relocated and new particles
  std::uint64_t chunks = 0;
};
struct DensifyBuffers : BufferTable<DensifySizes> {
  using BufferTable::BufferTable;
  Reals weights{*this, "weight", [](const DensifySizes&) { return std::uint64_t{3}; }};
  Reals sums{*this, "error_sums", [](const DensifySizes& s) { return s.chunks; }};
  Words dead{*this, "dead", [](const DensifySizes& s) { return s.chunks; }};
  Words share{*this, "share", [](const DensifySizes& s) { return s.particles; }};
  Words targets{*this, "targets", [](const DensifySizes& s) { return s.targets; }};
  Words source{*this, "source", [](const DensifySizes& s) { return s.targets; }};
  Words copies{*this, "copies", [](const DensifySizes& s) { return s.particles; }};
};

class DensifyStage {
 public:
  DensifyStage(const Device& device, Precision precision);

  /// Computes errors of a frame's rays -> ray_error[S], for Pass::backward(). Pixels: mean absolute difference
  /// of picture[3][S] and truth[3][S]. Beams: weighted distance (at most 1 m), intensity, and probability of
  /// the wrong decision between hit and drop; truth[2][S].
  void pixel_error(const shared::FrameParams& frame,
                   const WorldRays& world_rays,
                   const RealBuffer& picture,
                   const RealBuffer& truth,
                   RealBuffer& ray_error);
  void beam_error(const shared::FrameParams& frame,
                  const WorldRays& world_rays,
                  const Blended& blended,
                  const RealBuffer& truth,
                  const std::array<double, 3>& weights,
                  RealBuffer& ray_error);
  /// Adds each particle's share of the errors, distributed by render_bwd, to accumulated[N].
  void accumulate(const shared::FrameParams& frame,
                  const FrameBuffers& made,
                  const GradientBuffers& gradients,
                  RealBuffer& accumulated);

  /// Relocates particles that are nearly transparent (sigma < 0.005) or not finite, and adds up to `growth` new
  /// ones. Each copies a particle drawn in proportion to its accumulated error, and gets its owner; coincident
  /// particles share opacity and scale. The corresponding rows of `moments` (in the layout of params) and
  /// accumulated[N] are zeroed. Does nothing without accumulated errors. Waits.
  DensifyCounts relocate(ParticleBuffers& particles,
                         std::span<RealBuffer* const> moments,
                         RealBuffer& accumulated,
                         std::uint32_t growth,
                         const RandomKey& key);
  /// Applies the last relocate() to words[N][width] by particle: they grow, and targets copy their sources.
  void follow(Buffer<std::uint32_t>& words, std::uint32_t width);

  /// Moves nearly transparent particles visible in the frame of `keys` by strength (1/m) x covariance x normal
  /// numbers.
  void jitter(ParticleBuffers& particles,
              const Buffer<std::uint32_t>& keys,
              double strength,
              const RandomKey& key);

 private:
  /// Number of dead particles, and total error.
  struct Census {
    Chunks chunks;
    std::uint32_t dead = 0;
    double error = 0.0;
  };
  Census census(const ParticleBuffers& particles, const RealBuffer& accumulated);
  /// Draws targets and sources; false when errors are so uneven that no particle gets a share.
  bool draw(const ParticleBuffers& particles,
            const RealBuffer& accumulated,
            const Census& census,
            std::uint32_t growth,
            const RandomKey& key);
  void grow(ParticleBuffers& particles, std::span<RealBuffer* const> moments, std::uint32_t growth);
  /// Copies the sources' parameters to their targets; `before`: particles before growth.
  void copy(ParticleBuffers& particles, std::span<RealBuffer* const> moments, std::uint32_t before);
  void widen(
      RealBuffer& rows, std::uint32_t count, std::uint32_t stride, std::uint32_t new_stride, bool params);

  Device device_;
  Precision precision_;
  ScanStage scan_;
  DensifyBuffers buffers_;
  std::uint32_t changed_ = 0;  // targets of the last relocate()
  std::uint32_t particles_ = 0;  // after the last relocate()
  Kernel pixel_error_, beam_error_, accumulate_, weigh_, list_, draw_, copy_, clear_, copy_words_, widen_,
      jitter_;
};

}  // namespace simuli
