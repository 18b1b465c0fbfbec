#pragma once
// Behind a frame: losses of what was rendered, and Adam's step.
#include <cstdint>
#include <vector>

#include "host/render/frame/stages.hpp"

namespace simuli {

/// Sums of a picture's loss, over all known pixels and channels.
struct ImageLoss {
  double absolute = 0.0;
  double squared = 0.0;
  double dissimilarity = 0.0;  // 1 - SSIM; 0 where its scale is
};

/// Weights of a picture's losses over the number of values (3 x known pixels).
struct ImageLossScale {
  double absolute = 0.0;
  double squared = 0.0;
  double dissimilarity = 0.0;
};

/// Sums of a sweep's losses: |d^ - d| (m) and |intensity error| over returned rays, cross entropy and
/// wrong drop decisions over all rays.
struct LidarLoss {
  double distance_m = 0.0;
  double intensity = 0.0;
  double entropy = 0.0;
  double wrong = 0.0;
};

/// Weights of a sweep's losses over the number of rays that each is the mean of.
struct LidarLossScale {
  double distance = 0.0;
  double intensity = 0.0;
  double entropy = 0.0;
};

class SsimStage;  // host/render/frame/picture_stages.hpp

class LossStage {
 public:
  LossStage(const Device& device, Precision precision);
  LossStage(LossStage&&) noexcept;
  LossStage& operator=(LossStage&&) noexcept;
  LossStage(const LossStage&) = delete;
  LossStage& operator=(const LossStage&) = delete;
  ~LossStage();
  /// picture[3][S] (out itself, or what was made of it) -> grad_out. truth[3][S].
  ImageLoss run_image(const shared::FrameParams& frame,
                      FrameBuffers& buffers,
                      const RealBuffer& picture,
                      const RealBuffer& truth,
                      const ImageLossScale& scale);
  /// out -> grad_out. truth[2][S]: range, intensity.
  LidarLoss run_lidar(const shared::FrameParams& frame,
                      FrameBuffers& buffers,
                      const RealBuffer& truth,
                      const LidarLossScale& scale);

 private:
  std::vector<double> sums(std::size_t columns) const;
  Device device_;
  RealBuffer sums_;
  RealBuffer scale_;
  std::unique_ptr<SsimStage> ssim_;  // once asked for
  Kernel<shared::FrameParams,
         RealScalar,
         RealScalar,
         BufRealConst,
         BufRealConst,
         BufRealConst,
         BufReal,
         BufReal>
      image_;
  Kernel<shared::FrameParams, BufRealConst, BufRealConst, BufRealConst, BufRealConst, BufReal, BufReal>
      lidar_;
};

/// Adam on a parameter matrix: of one set, or of anything that every step moves as a whole.
class AdamStage {
 public:
  AdamStage(const Device& device, const ParticleBuffers& particles);
  AdamStage(const Device& device, Precision precision, std::size_t parameters);
  /// One step with rate[param_rows] on the particles that the frame of `keys` (FrameBuffers) did not cull;
  /// counts iterations itself.
  void run(ParticleBuffers& particles,
           const RealBuffer& grads,
           const Buffer<std::uint32_t>& keys,
           const std::vector<double>& rate);
  /// Step number `step` (from 1) with one rate on params[first, first + grads.count()), a multiple of 16.
  void run_dense(
      RealBuffer& params, const RealBuffer& grads, std::size_t first, double rate, std::uint64_t step);
  /// Gradient entries so far that were not finite and moved nothing. Waits.
  [[nodiscard]] std::uint32_t rejected() const { return rejected_.read_back(); }
  [[nodiscard]] Buffer<std::uint32_t>& rejections() { return rejected_; }
  [[nodiscard]] std::uint64_t& iteration() { return iteration_; }  // steps done
  /// The moments [param_rows][stride], for whoever renumbers or stores them.
  [[nodiscard]] RealBuffer& first_moment() { return first_; }
  [[nodiscard]] RealBuffer& second_moment() { return second_; }

 private:
  struct Matrix {
    std::uint32_t columns, stride, first;
    bool dense;  // all columns have a gradient: no keys are read
  };
  void launch(const Matrix& matrix,
              const Buffer<std::uint32_t>& keys,
              const std::vector<double>& rate,
              std::uint64_t step,
              const RealBuffer& grads,
              RealBuffer& params);
  int lanes_;
  std::uint64_t iteration_ = 0;
  RealBuffer rate_, first_, second_;
  Buffer<std::uint32_t> rejected_;
  Kernel<std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         Buf<const std::uint32_t>,
         BufRealConst,
         RealScalar,
         RealScalar,
         RealScalar,
         RealScalar,
         RealScalar,
         BufRealConst,
         BufReal,
         BufReal,
         BufReal,
         Buf<std::uint32_t>>
      adam_;
};

}  // namespace simuli
