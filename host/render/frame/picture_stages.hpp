#pragma once
// What happens to a camera's picture behind blending (METHOD sections 9 and 10): each stage a launcher with
// the stem of its kernel file. S ray slots; a scene that has no use for a stage never builds it.
#include "host/render/frame/stages.hpp"
#include "host/scene/appearance.hpp"

namespace simuli {

/// An environment texture on the device.
struct EnvironmentBuffers {
  EnvironmentBuffers(const Device& device, const EnvironmentMap& map, Precision precision);
  [[nodiscard]] EnvironmentMap download() const;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  RealBuffer texture;  // [height][width][4]
};

/// The foreground over the environment texture.
class EnvironmentStage {
 public:
  /// `lanes` per work-item; 0: as suits the device. Tests run the GPU's way on CPUs.
  EnvironmentStage(const Device& device, Precision precision, int lanes = 0);
  /// out (over black) -> out over the texture. S -> S.
  void run(const shared::FrameParams& frame, const EnvironmentBuffers& environment, FrameBuffers& buffers);
  /// out, grad_out -> grads[height][width][4], and tv_scale times the gradient of the total variation:
  /// squared differences of neighbours, sideways over cos(elevation), up and down times it.
  void run_backward(const shared::FrameParams& frame,
                    const EnvironmentBuffers& environment,
                    double tv_scale,
                    const FrameBuffers& buffers,
                    SortStage& sort,
                    ScanStage& scan,
                    RealBuffer& grads);

 private:
  Device device_;
  int lanes_;
  Buffer<std::uint32_t> cell_, slot_, cell_scratch_, slot_scratch_, first_;
  RealBuffer fraction_;
  Kernel<shared::FrameParams, std::uint32_t, std::uint32_t, BufSensor, BufRealConst, BufRealConst, BufReal>
      forward_;
  Kernel<shared::FrameParams,
         std::uint32_t,
         std::uint32_t,
         BufSensor,
         BufRealConst,
         BufRealConst,
         Buf<std::uint32_t>,
         Buf<std::uint32_t>,
         BufReal>
      cells_;
  Kernel<Buf<const std::uint32_t>, std::uint32_t, std::uint32_t, std::uint32_t, Buf<std::uint32_t>> ranges_;
  Kernel<shared::FrameParams,
         std::uint32_t,
         std::uint32_t,
         RealScalar,
         Buf<const std::uint32_t>,
         Buf<const std::uint32_t>,
         BufRealConst,
         BufRealConst,
         BufRealConst,
         BufRealConst,
         BufReal>
      gather_;
};

/// Bilateral grids on the device, one behind the other.
struct ColorGridBuffers {
  ColorGridBuffers(const Device& device, const ColorGrids& grids, Precision precision);
  /// Into `grids` of the same sizes.
  void download(ColorGrids& grids) const;
  /// Reals of one grid: [size_y][size_x][size_z][16].
  [[nodiscard]] std::uint32_t reals() const;
  int size_x = 0;
  int size_y = 0;
  int size_z = 0;
  RealBuffer grid;  // [grids][reals]
};

/// Weights of a grid's own losses: of the squared differences of neighbours and to the identity.
struct ColorGridScale {
  double variation = 0.0;
  double drift = 0.0;
};

/// A picture through one of its bilateral grids.
class ColorGridStage {
 public:
  /// For grids of the sizes of `grids`.
  ColorGridStage(const Device& device, const ColorGridBuffers& grids);
  /// out -> picture[3][S] by grid `index`. width, height: of the picture, px.
  void run(const shared::FrameParams& frame,
           int width,
           int height,
           const ColorGridBuffers& grids,
           std::size_t index,
           const RealBuffer& out,
           RealBuffer& picture);
  /// grad_out of the picture -> grad_out of what went in, grads[reals] of grid `index`.
  void run_backward(const shared::FrameParams& frame,
                    int width,
                    int height,
                    const ColorGridBuffers& grids,
                    std::size_t index,
                    const ColorGridScale& scale,
                    FrameBuffers& buffers,
                    RealBuffer& grads);

 private:
  std::size_t columns_, vertices_, partial_reals_;  // cells along x; of one grid; of one row of pixels
  RealBuffer partial_;
  Kernel<shared::FrameParams,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         BufRealConst,
         BufRealConst,
         BufReal>
      forward_;
  Kernel<shared::FrameParams,
         std::uint32_t,
         std::uint32_t,
         std::uint32_t,
         BufRealConst,
         BufRealConst,
         BufReal,
         BufReal>
      rows_;
  Kernel<std::uint32_t, std::uint32_t, RealScalar, RealScalar, BufRealConst, BufRealConst, BufReal> gather_;
};

/// Structural similarity: 1 - SSIM over 11 x 11 Gaussian windows, of known pixels alone.
class SsimStage {
 public:
  /// `lanes` as EnvironmentStage.
  SsimStage(const Device& device, Precision precision, int lanes = 0);
  /// picture, truth [3][S] -> sum of 1 - SSIM over known pixels and channels; adds `scale` times its gradient
  /// to grad_picture[3][S].
  double run(const shared::FrameParams& frame,
             const RealBuffer& world_ray,
             const RealBuffer& picture,
             const RealBuffer& truth,
             double scale,
             RealBuffer& grad_picture);

 private:
  int lanes_;
  shared::FrameParams sized_{};  // what the planes' margins were cleared for
  RealBuffer window_, planes_, moments_, slopes_, slope_rows_, sums_;
  Kernel<shared::FrameParams, std::uint32_t, BufRealConst, BufRealConst, BufRealConst, BufReal>
      planes_kernel_;
  Kernel<shared::FrameParams, BufRealConst, BufRealConst, BufReal> moments_kernel_;
  Kernel<shared::FrameParams,
         std::uint32_t,
         RealScalar,
         BufRealConst,
         BufRealConst,
         BufRealConst,
         BufReal,
         BufReal>
      windows_kernel_;
  Kernel<shared::FrameParams, BufRealConst, BufRealConst, BufReal> slope_rows_kernel_;
  Kernel<shared::FrameParams, std::uint32_t, BufRealConst, BufRealConst, BufRealConst, BufReal>
      gradient_kernel_;
};

}  // namespace simuli
