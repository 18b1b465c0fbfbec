// PSNR and SSIM of optim/base/metrics.hpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "host/core/base/linear_algebra.hpp"
#include "optim/base/metrics.hpp"

namespace simuli {
namespace {

constexpr int kWindow_px = 11;
constexpr double kWindowSigma_px = 1.5;
constexpr double kC1 = 0.01 * 0.01;  // (K1 L)^2 with the dynamic range L = 1
constexpr double kC2 = 0.03 * 0.03;

std::string size_of(const Image& image) {
  return fmt::format("{}x{}x{}", image.width, image.height, image.channels);
}

std::array<double, kWindow_px> gaussian_window() {
  std::array<double, kWindow_px> weights{};
  double sum = 0.0;
  for (int i = 0; i < kWindow_px; ++i) {
    const double x = (i - kWindow_px / 2) / kWindowSigma_px;
    weights[static_cast<std::size_t>(i)] = std::exp(-0.5 * x * x);
    sum += weights[static_cast<std::size_t>(i)];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// The five moments of a pair of pictures for SSIM: x, y, x^2, y^2, x y.
using Moments = std::array<double, 5>;

/// Windows without unknown pixels in row y0 of the valid region: [width - 10].
std::vector<bool> known_windows(const Image& truth, int y0) {
  std::vector<bool> known(static_cast<std::size_t>(truth.width - kWindow_px + 1), true);
  for (int y = y0; y < y0 + kWindow_px; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      if (truth.at(x, y, 0) >= 0.0F) continue;
      const int last = std::min(x, static_cast<int>(known.size()) - 1);
      for (int k = std::max(x - kWindow_px + 1, 0); k <= last; ++k)
        known[static_cast<std::size_t>(k)] = false;
    }
  }
  return known;
}

/// Moments of one channel under the vertical window whose top row is y0, for each column: [width].
std::vector<Moments> column_moments(const Image& rendered,
                                    const Image& truth,
                                    int channel,
                                    int y0,
                                    const std::array<double, kWindow_px>& window) {
  std::vector<Moments> columns(static_cast<std::size_t>(rendered.width), Moments{});
  for (int dy = 0; dy < kWindow_px; ++dy) {
    const double weight = window[static_cast<std::size_t>(dy)];
    for (int x = 0; x < rendered.width; ++x) {
      const double a = rendered.at(x, y0 + dy, channel);
      const double b = truth.at(x, y0 + dy, channel);
      Moments& m = columns[static_cast<std::size_t>(x)];
      m[0] += weight * a;
      m[1] += weight * b;
      m[2] += weight * a * a;
      m[3] += weight * b * b;
      m[4] += weight * a * b;
    }
  }
  return columns;
}

double ssim_of(const Moments& m) {
  const double variance_a = m[2] - m[0] * m[0];
  const double variance_b = m[3] - m[1] * m[1];
  const double covariance = m[4] - m[0] * m[1];
  return ((2.0 * m[0] * m[1] + kC1) * (2.0 * covariance + kC2)) /
         ((m[0] * m[0] + m[1] * m[1] + kC1) * (variance_a + variance_b + kC2));
}

}  // namespace

void check_pair(const char* metric, const Image& rendered, const Image& truth, int min_side_px) {
  for (const Image* image : {&rendered, &truth}) {
    const bool shape = image->width >= min_side_px && image->height >= min_side_px && image->channels >= 1;
    if (!shape) {
      throw_input_error(
          metric, "picture size", size_of(*image), fmt::format("sides of {} px or more", min_side_px));
    }
    const std::size_t values = static_cast<std::size_t>(image->width) *
                               static_cast<std::size_t>(image->height) *
                               static_cast<std::size_t>(image->channels);
    if (image->data.size() != values) {
      throw_input_error(metric, "picture values", std::to_string(image->data.size()), std::to_string(values));
    }
  }
  const bool equal =
      rendered.width == truth.width && rendered.height == truth.height && rendered.channels == truth.channels;
  if (!equal) throw_input_error(metric, "size of the rendered picture", size_of(rendered), size_of(truth));
}

double psnr_db(const Image& rendered, const Image& truth) {
  check_pair("psnr_db", rendered, truth, 1);
  double sum = 0.0;
  std::size_t known = 0;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    if (truth.data[i] < 0.0F) continue;
    const double difference = static_cast<double>(rendered.data[i]) - static_cast<double>(truth.data[i]);
    sum += difference * difference;
    ++known;
  }
  const double mean_square = sum / static_cast<double>(known);
  return -10.0 * std::log10(mean_square);  // log10(0) = -inf: identical pictures give +inf
}

Image colour_corrected(const Image& rendered,
                       const Image& truth,
                       const std::vector<float>& weight,
                       Tone tone) {
  check_pair("colour_corrected", rendered, truth, 1);
  using Pixels = Eigen::Map<const Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  const Eigen::Index channels = truth.channels;
  const auto pixels = static_cast<Eigen::Index>(truth.data.size()) / channels;
  const Pixels from(rendered.data.data(), pixels, channels), to(truth.data.data(), pixels, channels);
  const bool bends = tone == Tone::kQuadratic;
  Eigen::MatrixXd coloured = Eigen::MatrixXd::Ones(pixels, 1 + (bends ? 2 : 1) * channels);
  coloured.leftCols(channels) = from.matrix().cast<double>();
  if (bends) coloured.rightCols(channels) = from.square().matrix().cast<double>();
  Eigen::VectorXd counts = (to.rowwise().minCoeff() >= 0.0F).matrix().cast<double>();
  if (!weight.empty()) counts.array() *= Pixels(weight.data(), pixels, 1).cast<double>();
  // Grey and plain pictures have many equally near transforms: the smallest is chosen.
  const Eigen::MatrixXd weighted = counts.asDiagonal() * coloured;
  const Eigen::MatrixXd transform = pseudo_inverse<Eigen::MatrixXd>(weighted.transpose() * coloured) *
                                    (weighted.transpose() * to.matrix().cast<double>());
  Image corrected = rendered;
  Eigen::Map<Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      corrected.data.data(), pixels, channels) =
      (coloured * transform).cast<float>().cwiseMax(0.0F).cwiseMin(1.0F);
  return corrected;
}

double psnr_corrected_db(const Image& rendered, const Image& truth) {
  const double corrected_db = psnr_db(colour_corrected(rendered, truth), truth);
  return std::fmax(corrected_db, psnr_db(rendered, truth));  // equal except for rounding
}

double ssim(const Image& rendered, const Image& truth) {
  check_pair("ssim", rendered, truth, kWindow_px);
  const std::array<double, kWindow_px> window = gaussian_window();
  const int valid_width = truth.width - kWindow_px + 1;
  const int valid_height = truth.height - kWindow_px + 1;
  double sum = 0.0;
  std::size_t windows = 0;
  for (int channel = 0; channel < truth.channels; ++channel) {
    for (int y = 0; y < valid_height; ++y) {
      Interruption::ask();
      const std::vector<bool> known = known_windows(truth, y);
      const std::vector<Moments> columns = column_moments(rendered, truth, channel, y, window);
      for (int x = 0; x < valid_width; ++x) {
        if (!known[static_cast<std::size_t>(x)]) continue;
        ++windows;
        Moments m{};
        for (int dx = 0; dx < kWindow_px; ++dx) {
          for (std::size_t k = 0; k < m.size(); ++k) {
            m[k] += window[static_cast<std::size_t>(dx)] * columns[static_cast<std::size_t>(x + dx)][k];
          }
        }
        sum += ssim_of(m);
      }
    }
  }
  return sum / static_cast<double>(windows);
}

}  // namespace simuli
