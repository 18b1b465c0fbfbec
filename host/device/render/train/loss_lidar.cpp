// Launcher of "kernels/loss_lidar.cl".
#include <algorithm>

#include "host/device/render/options/lane_shape.hpp"
#include "host/device/render/train/loss_stages.hpp"

namespace simuli {

LidarLossStage::LidarLossStage(const Device& device, Precision precision, std::size_t work_items)
    : buffers_(device, precision),
      work_items_(loss_work_items(device, work_items)),
      loss_lidar_(Program(device,
                          "kernels/loss_lidar.cl",
                          lane_options(device, precision).define("LS", work_items_)),
                  "loss_lidar") {}

LidarLoss LidarLossStage::run(const shared::FrameParams& frame,
                              const FrameConstants& constants,
                              const WorldRays& world_rays,
                              const Blended& blended,
                              const RealBuffer& truth,
                              const LidarLossScale& scale,
                              GradientBuffers& out) {
  const std::size_t tiles = std::size_t{frame.tiles_x} * frame.tiles_y;
  out.grad_out.reserve(std::size_t{5} * frame.slots);
  buffers_.reserve({tiles});
  buffers_.scale.assign(
      std::vector<double>{scale.distance, scale.intensity, scale.entropy, scale.function_entropy});
  loss_lidar_.run(tiles * work_items_,
                  work_items_,
                  {{"frame", frame},
                   constants,
                   {"scale", buffers_.scale},
                   world_rays,
                   blended,
                   {"truth", truth},
                   {"grad_out", out.grad_out},
                   {"sums", buffers_.sums}});
  const std::vector<double> total = column_sums(buffers_.sums, LidarLossBuffers::kSums);
  LidarLoss loss{total[0], total[1], total[2], total[3]};
  std::copy(total.begin() + 4, total.end(), loss.drop.begin());
  return loss;
}

}  // namespace simuli
