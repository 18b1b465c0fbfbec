#pragma once
// Relocation and growth of a particle set by reconstruction error (METHOD section 11).
#include <array>
#include <cstdint>
#include <span>

#include "host/render/frame/stages.hpp"

namespace simuli {

/// What random numbers depend on, beside the particle.
struct RandomKey {
  std::uint64_t seed = 0;
  std::uint32_t iteration = 0;
  std::uint32_t set = 0;  // tells the sets of a scene apart
};

struct DensifyCounts {
  std::uint32_t relocated = 0;
  std::uint32_t grown = 0;
};

class DensifyStage {
 public:
  DensifyStage(const Device& device, Precision precision);

  /// Errors of a frame's rays -> ray_error[S], for Pass::backward. Pixels: mean absolute
  /// difference of picture[3][S] and truth[3][S]. Beams: weighted distance (1 m at most), intensity and
  /// probability of the wrong one of hit and drop; truth[2][S].
  void pixel_error(const shared::FrameParams& frame,
                   const FrameBuffers& buffers,
                   const RealBuffer& picture,
                   const RealBuffer& truth,
                   RealBuffer& ray_error);
  void beam_error(const shared::FrameParams& frame,
                  const FrameBuffers& buffers,
                  const RealBuffer& truth,
                  const std::array<double, 3>& weights,
                  RealBuffer& ray_error);
  /// Adds each particle's share of them, as render_bwd has blended it, to accumulated[N].
  void accumulate(const shared::FrameParams& frame, const FrameBuffers& buffers, RealBuffer& accumulated);

  /// Relocates the particles that are nearly transparent (sigma < 0.005) or not finite, and adds up to
  /// `growth` new ones. Each takes the parameters of one drawn in proportion to its accumulated error, and
  /// belongs to the same actor; those that share a place share its opacity and scale. The matching rows of
  /// `moments` (of params' layout) start at 0, and so does accumulated[N]. Nothing happens while no error has
  /// been accumulated. Waits.
  DensifyCounts relocate(ParticleBuffers& particles,
                         std::span<RealBuffer* const> moments,
                         RealBuffer& accumulated,
                         std::uint32_t growth,
                         const RandomKey& key);
  /// Lets words[N][width] that belong to particles follow the last relocate(): they grow, and targets have
  /// those of their sources.
  void follow(Buffer<std::uint32_t>& words, std::uint32_t width);

  /// Moves nearly transparent particles of the frame of `keys` by strength (1/m) x covariance x normal
  /// numbers.
  void jitter(ParticleBuffers& particles,
              const Buffer<std::uint32_t>& keys,
              double strength,
              const RandomKey& key);

 private:
  void widen(
      RealBuffer& rows, std::uint32_t count, std::uint32_t stride, std::uint32_t new_stride, bool params);

  Device device_;
  Precision precision_;
  ScanStage scan_;
  RealBuffer weights_, sums_;
  Buffer<std::uint32_t> dead_, share_, targets_, source_, copies_;
  std::uint32_t changed_ = 0;    // targets of the last relocate()
  std::uint32_t particles_ = 0;  // after it
  Kernel<std::uint32_t, BufRealConst, BufRealConst, BufRealConst, BufReal> pixel_error_;
  Kernel<std::uint32_t, BufRealConst, BufRealConst, BufRealConst, BufRealConst, BufReal> beam_error_;
  Kernel<std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<const shared::Footprint>,
         Buf<const std::uint32_t>,
         BufRealConst,
         BufReal>
      accumulate_;
  Kernel<std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         BufRealConst,
         BufRealConst,
         Buf<std::uint32_t>,
         BufReal>
      weigh_;
  Kernel<std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         BufRealConst,
         BufRealConst,
         Buf<const std::uint32_t>,
         RealScalar,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>>
      list_;
  Kernel<std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>>
      draw_;
  Kernel<std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         BufReal>
      copy_;
  Kernel<std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         BufReal>
      clear_;
  Kernel<std::uint32_t, std::uint32_t, Buf<const std::uint32_t>, Buf<const std::uint32_t>, Buf<std::uint32_t>>
      copy_words_;
  Kernel<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t, BufRealConst, BufReal>
      widen_;
  Kernel<std::uint32_t,
         std::uint32_t,
         RealScalar,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         BufReal>
      jitter_;
};

}  // namespace simuli
