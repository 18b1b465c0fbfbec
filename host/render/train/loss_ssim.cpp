// Launcher of "kernels/loss_ssim.cl".
#include <array>
#include <cmath>

#include "host/render/frame/picture_stages.hpp"
#include "host/render/options/lane_shape.hpp"

namespace simuli {
namespace {

constexpr int kRadius_px = 5;
constexpr double kSigma_px = 1.5;
constexpr std::size_t kMarginX_px = 16;  // as MARGIN_X

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
  return {device, "kernels/loss_ssim.cl", BuildOptions().real(precision).define("V", lanes)};
}

}  // namespace

SsimStage::SsimStage(const Device& device, Precision precision, int lanes)
    : lanes_(lanes == 0 ? lane_shape_of(device, precision).lanes : lanes),
      window_(device, "SSIM window", precision),
      planes_(device, "SSIM planes", precision),
      moments_(device, "SSIM moments", precision),
      slopes_(device, "SSIM slopes", precision),
      slope_rows_(device, "SSIM slope rows", precision),
      sums_(device, "SSIM sums", precision),
      planes_kernel_(ssim_program(device, precision, lanes_), "ssim_planes"),
      moments_kernel_(ssim_program(device, precision, lanes_), "ssim_moments"),
      windows_kernel_(ssim_program(device, precision, lanes_), "ssim_windows"),
      slope_rows_kernel_(ssim_program(device, precision, lanes_), "ssim_slope_rows"),
      gradient_kernel_(ssim_program(device, precision, lanes_), "ssim_gradient") {
  window_.assign(gaussian_window());
}

double SsimStage::run(const shared::FrameParams& frame,
                      const RealBuffer& world_ray,
                      const RealBuffer& picture,
                      const RealBuffer& truth,
                      double scale,
                      RealBuffer& grad_picture) {
  const std::size_t tiles = std::size_t{frame.tiles_x} * frame.tiles_y;
  const std::size_t strips = tiles * SIM_SLOT_ROW / static_cast<std::size_t>(lanes_);
  if (frame.tiles_x != sized_.tiles_x || frame.tiles_y != sized_.tiles_y) {
    const std::size_t plane = (std::size_t{frame.tiles_x} * SIM_SLOT_ROW + 2 * kMarginX_px) *
                              (std::size_t{frame.tiles_y} * SIM_SLOT_ROWS + 2 * kRadius_px);
    const std::array<std::pair<RealBuffer*, std::size_t>, 4> all{
        {{&planes_, 3}, {&moments_, 6}, {&slopes_, 3}, {&slope_rows_, 3}}};
    for (const auto& [buffer, planes] : all) {
      buffer->reserve(planes * plane);
      buffer->fill(0.0);
    }
    sums_.reserve(3 * strips);
    sized_ = frame;
  }
  const std::size_t local = lanes_ == 1 ? 64 : 1;
  const std::size_t items = round_up(strips, local);
  for (std::uint32_t channel = 0; channel < 3; ++channel) {
    planes_kernel_.launch(items, local, frame, channel, world_ray, picture, truth, planes_);
    moments_kernel_.launch(items, local, frame, window_, planes_, moments_);
    windows_kernel_.launch(items, local, frame, channel, scale, window_, planes_, moments_, slopes_, sums_);
    slope_rows_kernel_.launch(items, local, frame, window_, slopes_, slope_rows_);
    gradient_kernel_.launch(items, local, frame, channel, window_, planes_, slope_rows_, grad_picture);
  }
  double sum = 0.0;
  for (const double part : sums_.download_double()) sum += part;
  return sum;
}

}  // namespace simuli
