// Launcher of "kernels/loss_ssim.cl".
#include <cmath>

#include "host/device/render/options/lane_shape.hpp"
#include "host/device/render/train/loss_stages.hpp"

namespace simuli {
namespace {

constexpr int kRadius_px = SsimSizes::kRadius_px;
constexpr double kSigma_px = 1.5;

std::vector<double> gaussian_window() {
  std::vector<double> weights;
  double sum = 0.0;
  for (int i = -kRadius_px; i <= kRadius_px; ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (kSigma_px * kSigma_px)));
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

Program ssim_program(const Device& device, Precision precision, int lanes) {
  return {device, "kernels/loss_ssim.cl", lane_options(device, precision, lanes)};
}

}  // namespace

SsimSizes SsimStage::sizes(std::uint32_t tiles_x, std::uint32_t tiles_y, int lanes) {
  const std::uint64_t columns = std::uint64_t{tiles_x} * tiles_y * SIM_TILE_SIDE;
  return {tiles_x, tiles_y, columns / static_cast<std::uint64_t>(lanes)};
}

SsimStage::SsimStage(const Device& device, Precision precision, int lanes)
    : lanes_(lanes == 0 ? lane_shape_of(device, precision).lanes : lanes),
      buffers_(device, precision),
      planes_(ssim_program(device, precision, lanes_), "ssim_planes"),
      moments_(ssim_program(device, precision, lanes_), "ssim_moments"),
      windows_(ssim_program(device, precision, lanes_), "ssim_windows"),
      slope_rows_(ssim_program(device, precision, lanes_), "ssim_slope_rows"),
      gradient_(ssim_program(device, precision, lanes_), "ssim_gradient") {
  buffers_.window.assign(gaussian_window());
}

void SsimStage::clear_margins(const shared::FrameParams& frame) {
  if (frame.tiles_x == sized_.tiles_x && frame.tiles_y == sized_.tiles_y) return;
  buffers_.reserve(sizes(frame.tiles_x, frame.tiles_y, lanes_));
  for (RealBuffer* buffer : {&buffers_.planes, &buffers_.moments, &buffers_.slopes, &buffers_.slope_rows}) {
    buffer->fill(0.0);
  }
  sized_ = frame;
}

double SsimStage::run(const shared::FrameParams& frame,
                      const RealBuffer& world_ray,
                      const RealBuffer& picture,
                      const RealBuffer& truth,
                      double scale,
                      RealBuffer& grad_picture) {
  clear_margins(frame);
  const std::size_t local = lanes_ == 1 ? 64 : 1;
  const std::size_t items = round_up(sizes(frame.tiles_x, frame.tiles_y, lanes_).strips, local);
  for (std::uint32_t channel = 0; channel < 3; ++channel) {
    planes_.run(items,
                local,
                {{"frame", frame},
                 {"channel", channel},
                 {"world_ray", world_ray},
                 {"picture", picture},
                 {"truth", truth},
                 buffers_});
    moments_.run(items, local, {{"frame", frame}, buffers_});
    windows_.run(
        items,
        local,
        {{"frame", frame}, {"channel", channel}, {"scale", scale}, buffers_, {"sums", buffers_.sums}});
    slope_rows_.run(items, local, {{"frame", frame}, buffers_});
    gradient_.run(
        items, local, {{"frame", frame}, {"channel", channel}, buffers_, {"grad_picture", grad_picture}});
  }
  double sum = 0.0;
  for (const double part : buffers_.sums.download_double()) sum += part;
  return sum;
}

}  // namespace simuli
