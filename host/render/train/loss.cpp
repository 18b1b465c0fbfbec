// Launcher of "kernels/loss_image.cl" and "kernels/loss_lidar.cl".
#include "host/render/train/loss_stages.hpp"
#include "host/render/frame/picture_stages.hpp"
#include "host/render/options/lane_shape.hpp"

namespace simuli {
namespace {

BuildOptions loss_options(const Device& device, Precision precision) {
  BuildOptions options;
  return options.real(precision).define("V", lane_shape_of(device, precision).lanes);
}

constexpr std::size_t kGradRows = 5;

}  // namespace

LossStage::LossStage(const Device& device, Precision precision)
    : device_(device),
      sums_(device, "loss sums", precision),
      scale_(device, "loss scale", precision),
      image_(Program(device, "kernels/loss_image.cl", loss_options(device, precision)), "loss_image"),
      lidar_(Program(device, "kernels/loss_lidar.cl", loss_options(device, precision)), "loss_lidar") {}

LossStage::LossStage(LossStage&&) noexcept = default;
LossStage& LossStage::operator=(LossStage&&) noexcept = default;
LossStage::~LossStage() = default;

std::vector<double> LossStage::sums(std::size_t columns) const {
  const std::vector<double> parts = sums_.download_double();
  std::vector<double> total(columns, 0.0);
  for (std::size_t i = 0; i < parts.size(); ++i) total[i % columns] += parts[i];
  return total;
}

ImageLoss LossStage::run_image(const shared::FrameParams& frame,
                               FrameBuffers& b,
                               const RealBuffer& picture,
                               const RealBuffer& truth,
                               const ImageLossScale& scale) {
  const std::size_t tiles = std::size_t{frame.tiles_x} * frame.tiles_y;
  b.grad_out.reserve(kGradRows * frame.slots);
  sums_.reserve(2 * tiles);
  image_.launch(
      tiles, 1, frame, scale.absolute, scale.squared, b.world_ray, picture, truth, b.grad_out, sums_);
  const std::vector<double> total = sums(2);
  ImageLoss loss{total[0], total[1], 0.0};
  if (scale.dissimilarity > 0.0) {
    if (!ssim_) ssim_ = std::make_unique<SsimStage>(device_, picture.precision());
    loss.dissimilarity = ssim_->run(frame, b.world_ray, picture, truth, scale.dissimilarity, b.grad_out);
  }
  return loss;
}

LidarLoss LossStage::run_lidar(const shared::FrameParams& frame,
                               FrameBuffers& b,
                               const RealBuffer& truth,
                               const LidarLossScale& scale) {
  const std::size_t tiles = std::size_t{frame.tiles_x} * frame.tiles_y;
  b.grad_out.reserve(kGradRows * frame.slots);
  sums_.reserve(4 * tiles);
  scale_.assign(std::vector<double>{scale.distance, scale.intensity, scale.entropy});
  lidar_.launch(tiles, 1, frame, scale_, b.world_ray, b.out, truth, b.grad_out, sums_);
  const std::vector<double> total = sums(4);
  return {total[0], total[1], total[2], total[3]};
}

}  // namespace simuli
