// Launcher of "kernels/loss_image.cl" and "kernels/loss_lidar.cl".
#include "host/render/stages.hpp"

namespace simuli {
namespace {

BuildOptions loss_options(const Device& device, Precision precision) {
  BuildOptions options;
  return options.real(precision).define("V", LaneShape::of(device, precision).lanes);
}

constexpr std::size_t kGradRows = 5;

}  // namespace

LossStage::LossStage(const Device& device, Precision precision)
    : sums_(device, "loss sums", precision),
      scale_(device, "loss scale", precision),
      image_(Program(device, "kernels/loss_image.cl", loss_options(device, precision)), "loss_image"),
      lidar_(Program(device, "kernels/loss_lidar.cl", loss_options(device, precision)), "loss_lidar") {}

std::vector<double> LossStage::sums(std::size_t columns) const {
  const std::vector<double> parts = sums_.download_double();
  std::vector<double> total(columns, 0.0);
  for (std::size_t i = 0; i < parts.size(); ++i) total[i % columns] += parts[i];
  return total;
}

ImageLoss LossStage::run_image(const shared::FrameParams& frame,
                               FrameBuffers& b,
                               const RealBuffer& truth,
                               double absolute_scale,
                               double squared_scale) {
  const std::size_t tiles = std::size_t{frame.tiles_x} * frame.tiles_y;
  b.grad_out.reserve(kGradRows * frame.slots);
  sums_.reserve(2 * tiles);
  image_.launch(tiles, 1, frame, absolute_scale, squared_scale, b.world_ray, b.out, truth, b.grad_out, sums_);
  const std::vector<double> total = sums(2);
  return {total[0], total[1]};
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
