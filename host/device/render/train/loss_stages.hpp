#pragma once
// Loss stages after rendering, which write grad_out for the backward pass.
#include <optional>
#include <vector>

#include "host/device/render/backward/gradient_buffers.hpp"
#include "host/device/render/frame/stages.hpp"
#include "host/device/render/train/losses.hpp"

namespace simuli {

/// Sizes of the SSIM buffers of one channel of a picture.
struct SsimSizes {
  std::uint64_t tiles_x = 0;
  std::uint64_t tiles_y = 0;
  std::uint64_t strips = 0;

  static constexpr std::uint64_t kRadius_px = 5;
  static constexpr std::uint64_t kMarginX_px = 16;  // as SIM_SSIM_MARGIN_X of loss_ssim.cl
  /// Pixels of a plane: the picture and its margins.
  [[nodiscard]] std::uint64_t plane() const {
    return (tiles_x * SIM_TILE_SIDE + 2 * kMarginX_px) * (tiles_y * SIM_TILE_SIDE + 2 * kRadius_px);
  }
};
struct SsimBuffers : BufferTable<SsimSizes> {
  using BufferTable::BufferTable;
  Reals window{*this, "window", [](const SsimSizes&) { return 2 * SsimSizes::kRadius_px + 1; }};
  Reals planes{*this, "planes", [](const SsimSizes& s) { return 3 * s.plane(); }};
  Reals moments{*this, "moments", [](const SsimSizes& s) { return 6 * s.plane(); }};
  Reals slopes{*this, "slopes", [](const SsimSizes& s) { return 3 * s.plane(); }};
  Reals slope_rows{*this, "slope_rows", [](const SsimSizes& s) { return 3 * s.plane(); }};
  Reals sums{*this, "ssim_sums", [](const SsimSizes& s) { return 3 * s.strips; }};
};

/// Structural similarity: 1 - SSIM over 11 x 11 Gaussian windows of known pixels.
class SsimStage {
 public:
  /// `lanes` as in EnvironmentStage.
  SsimStage(const Device& device, Precision precision, int lanes = 0);
  /// Returns the sum of 1 - SSIM of picture, truth [3][S] over known pixels and channels; adds `scale` times
  /// its gradient to grad_picture[3][S].
  double run(const shared::FrameParams& frame,
             const RealBuffer& world_ray,
             const RealBuffer& picture,
             const RealBuffer& truth,
             double scale,
             RealBuffer& grad_picture);
  /// Returns the sizes for pictures with these tiles.
  [[nodiscard]] static SsimSizes sizes(std::uint32_t tiles_x, std::uint32_t tiles_y, int lanes);

 private:
  void clear_margins(const shared::FrameParams& frame);
  int lanes_;
  shared::FrameParams sized_{};  // frame whose plane margins are zeroed
  SsimBuffers buffers_;
  Kernel planes_, moments_, windows_, slope_rows_, gradient_;
};

struct LossSizes {
  std::uint64_t tiles = 0;
};
struct ImageLossBuffers : BufferTable<LossSizes> {
  using BufferTable::BufferTable;
  Reals sums{*this, "image_sums", [](const LossSizes& s) { return 2 * s.tiles; }};
};
struct LidarLossBuffers : BufferTable<LossSizes> {
  using BufferTable::BufferTable;
  Reals sums{*this, "lidar_sums", [](const LossSizes& s) { return kSums * s.tiles; }};
  Reals scale{*this, "loss_scale", [](const LossSizes&) { return std::uint64_t{4}; }};
  static constexpr std::uint64_t kSums = 4 + RayDrop::kParameters;
};

/// Work-items per tile: `asked`, or 0: chosen for the device. Tests run the GPU configuration on CPUs.
[[nodiscard]] std::size_t loss_work_items(const Device& device, std::size_t requested);

class ImageLossStage {
 public:
  /// `work_items` as in loss_work_items().
  ImageLossStage(const Device& device, Precision precision, std::size_t work_items = 0);
  /// out, as rendered, and picture[3][S] (out itself or the corrected picture) -> grad_out. truth[3][S]. Waits.
  ImageLoss run(const shared::FrameParams& frame,
                const WorldRays& world_rays,
                const RealBuffer& rendered,
                const RealBuffer& picture,
                const RealBuffer& truth,
                const ImageLossScale& scale,
                GradientBuffers& out);

 private:
  Device device_;
  ImageLossBuffers buffers_;
  std::optional<SsimStage> ssim_;  // made on demand
  std::size_t work_items_;
  Kernel loss_image_;
};

class LidarLossStage {
 public:
  /// `work_items` as in loss_work_items().
  LidarLossStage(const Device& device, Precision precision, std::size_t work_items = 0);
  /// out -> grad_out. truth[2][S]: range, intensity. Waits.
  LidarLoss run(const shared::FrameParams& frame,
                const FrameConstants& constants,
                const WorldRays& world_rays,
                const Blended& blended,
                const RealBuffer& truth,
                const LidarLossScale& scale,
                GradientBuffers& out);

 private:
  LidarLossBuffers buffers_;
  std::size_t work_items_;
  Kernel loss_lidar_;
};

/// Sums parts[n][columns] in order. Waits.
[[nodiscard]] std::vector<double> column_sums(const RealBuffer& parts, std::size_t columns);

}  // namespace simuli
