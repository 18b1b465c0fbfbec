// Launcher of "kernels/loss_image.cl".
#include "host/device/render/options/lane_shape.hpp"
#include "host/device/render/train/loss_stages.hpp"

namespace simuli {

std::vector<double> column_sums(const RealBuffer& parts, std::size_t columns) {
  const std::vector<double> values = parts.download_double();
  std::vector<double> total(columns, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) total[i % columns] += values[i];
  return total;
}

std::size_t loss_work_items(const Device& device, std::size_t requested) {
  if (requested != 0) return requested;
  return device.info().is_cpu ? 1 : 32;
}

ImageLossStage::ImageLossStage(const Device& device, Precision precision, std::size_t work_items)
    : device_(device),
      buffers_(device, precision),
      work_items_(loss_work_items(device, work_items)),
      loss_image_(
          Program(device, "kernels/loss_image.cl", lane_options(device, precision).define("LS", work_items_)),
          "loss_image") {}

ImageLoss ImageLossStage::run(const shared::FrameParams& frame,
                              const WorldRays& world_rays,
                              const RealBuffer& rendered,
                              const RealBuffer& picture,
                              const RealBuffer& truth,
                              const ImageLossScale& scale,
                              GradientBuffers& out) {
  const std::size_t tiles = std::size_t{frame.tiles_x} * frame.tiles_y;
  out.grad_out.reserve(std::size_t{5} * frame.slots);
  buffers_.reserve({tiles});
  loss_image_.run(tiles * work_items_,
                  work_items_,
                  {{"frame", frame},
                   {"absolute_scale", scale.absolute},
                   {"squared_scale", scale.squared},
                   {"sky_scale", scale.sky},
                   {"sky_per_m", 1.0 / scale.sky_from_m},
                   world_rays,
                   {"out", rendered},
                   {"picture", picture},
                   {"truth", truth},
                   {"grad_out", out.grad_out},
                   {"sums", buffers_.sums}});
  const std::vector<double> total = column_sums(buffers_.sums, 2);
  ImageLoss loss{total[0], total[1], 0.0};
  if (scale.dissimilarity > 0.0) {
    if (!ssim_) ssim_.emplace(device_, picture.precision());
    loss.dissimilarity =
        ssim_->run(frame, world_rays.world_ray, picture, truth, scale.dissimilarity, out.grad_out);
  }
  return loss;
}

}  // namespace simuli
