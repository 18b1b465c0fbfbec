// FLIP of optim/base/metrics.hpp: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem, Fairchild: FLIP: A
// Difference Evaluator for Alternating Images, PACMCGIT 3(2), 2020. Comments cite its sections.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "host/core/base/interruption.hpp"
#include "host/core/base/srgb.hpp"
#include "optim/base/metrics.hpp"

namespace simuli {
namespace {

using std::numbers::pi;
using Plane = Eigen::ArrayXXf;  // [width, height]
using Planes = std::array<Plane, 3>;
using Kernel = std::vector<float>;

// Viewing conditions: 3840 px on 0.7 m from a distance of 0.7 m.
constexpr double kPixelsPerDegree = 3840.0 * pi / 180.0;

Kernel kernel_of(int radius, const std::function<double(double)>& at) {
  Kernel out;
  for (int i = -radius; i <= radius; ++i) out.push_back(static_cast<float>(at(i)));
  return out;
}

/// Scales positive weights to a sum of 1, and negative weights to -1.
Kernel normalized(Kernel kernel) {
  float above = 0.0F, below = 0.0F;
  for (const float k : kernel) (k > 0.0F ? above : below) += std::fabs(k);
  for (float& k : kernel) k /= k > 0.0F ? above : below;
  return kernel;
}

/// Extends the border.
Plane along_second(const Plane& in, const Kernel& kernel) {
  Interruption::ask();
  Plane out = Plane::Zero(in.rows(), in.cols());
  const auto radius = static_cast<Eigen::Index>(kernel.size() / 2);
  for (Eigen::Index c = 0; c < in.cols(); ++c) {
    for (Eigen::Index i = -radius; i <= radius; ++i) {
      out.col(c) += kernel[static_cast<std::size_t>(i + radius)] *
                    in.col(std::clamp<Eigen::Index>(c + i, 0, in.cols() - 1));
    }
  }
  return out;
}
Plane convolved(const Plane& in, const Kernel& x, const Kernel& y) {
  return along_second(along_second(in, y).transpose(), x).transpose();
}

Planes times(const Eigen::Matrix3d& m, const Planes& in) {
  const Eigen::Matrix3f f = m.cast<float>();
  Planes out;
  for (int k = 0; k < 3; ++k) {
    out[static_cast<std::size_t>(k)] = f(k, 0) * in[0] + f(k, 1) * in[1] + f(k, 2) * in[2];
  }
  return out;
}

/// X, Y, Z relative to white, from linear RGB with sRGB primaries.
Eigen::Matrix3d xyz_from_rgb() {
  Eigen::Matrix3d m;
  m << 10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0,  //
      2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0,     //
      1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0;
  return m.rowwise().sum().cwiseInverse().asDiagonal() * m;
}

/// Y, X - Y, Y - Z: the opponent space YCzCx up to factors, which do not affect the filters.
Eigen::Matrix3d opponent_from_rgb() {
  Eigen::Matrix3d m;
  m << 0, 1, 0, 1, -1, 0, 0, 1, -1;
  return m * xyz_from_rgb();
}

/// L*, and a* and b* with the Hunt adjustment, which lowers them in the dark (4.1.3).
Planes lab_of(const Planes& rgb) {
  Planes f = times(xyz_from_rgb(), rgb);
  constexpr float kDelta = 6.0F / 29.0F;
  for (Plane& plane : f) {
    plane = (plane > kDelta * kDelta * kDelta)
                .select(plane.max(0.0F).pow(1.0F / 3.0F), plane / (3.0F * kDelta * kDelta) + 4.0F / 29.0F);
  }
  const Plane lightness = 116.0F * f[1] - 16.0F;
  return {lightness, 5.0F * lightness * (f[0] - f[1]), 2.0F * lightness * (f[1] - f[2])};
}

Plane hyab(const Planes& a, const Planes& b) {
  return (a[0] - b[0]).abs() + ((a[1] - b[1]).square() + (a[2] - b[2]).square()).sqrt();
}

/// Filters opponent channels by contrast sensitivity (4.1.1); returns linear RGB.
Planes seen(const Planes& opponent) {
  struct Gaussian {
    double a, b;
  };
  const std::array<std::vector<Gaussian>, 3> sensitivity{
      {{{1.0, 0.0047}}, {{1.0, 0.0053}}, {{34.1, 0.04}, {13.5, 0.025}}}};
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * pi * pi)) * kPixelsPerDegree));
  Planes out;
  for (std::size_t k = 0; k < 3; ++k) {
    out[k] = Plane::Zero(opponent[k].rows(), opponent[k].cols());
    double whole = 0.0;
    for (const auto& [a, b] : sensitivity[k]) {
      const Kernel kernel = kernel_of(
          radius, [b = b](double i) { return std::exp(-std::pow(pi * i / kPixelsPerDegree, 2) / b); });
      double sum = 0.0;
      for (const float value : kernel) sum += static_cast<double>(value);
      const double weight = a * std::sqrt(pi / b) * sum * sum;
      out[k] += static_cast<float>(weight) * convolved(opponent[k], normalized(kernel), normalized(kernel));
      whole += weight;
    }
    out[k] /= static_cast<float>(whole);
  }
  out = times(opponent_from_rgb().inverse(), out);
  for (Plane& plane : out) plane = plane.max(0.0F).min(1.0F);
  return out;
}

/// Magnitudes of edges and of points in lightness (4.2).
std::array<Plane, 2> features(const Plane& lightness) {
  constexpr double kSigma_px = 0.5 * 0.082 * kPixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3.0 * kSigma_px));
  const auto bell = [](double i) { return std::exp(-i * i / (2.0 * kSigma_px * kSigma_px)); };
  const Kernel smooth = normalized(kernel_of(radius, bell));
  std::array<Plane, 2> out;
  for (int kind = 0; kind < 2; ++kind) {
    const Kernel change = normalized(kernel_of(radius, [&](double i) {
      return (kind == 0 ? -i : i * i / (kSigma_px * kSigma_px) - 1.0) * bell(i);
    }));
    out[static_cast<std::size_t>(kind)] =
        (convolved(lightness, change, smooth).square() + convolved(lightness, smooth, change).square())
            .sqrt();
  }
  return out;
}

/// Linear RGB; black where `truth` is unknown.
Planes linear(const Image& image, const Image& truth) {
  Planes out;
  for (int k = 0; k < 3; ++k) {
    Plane& plane = out[static_cast<std::size_t>(k)];
    plane.resize(image.width, image.height);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x)
        plane(x, y) = truth.at(x, y, 0) < 0.0F ? 0.0F : linear_of(image.at(x, y, k));
    }
  }
  return out;
}

/// Colour differences from 0 to 1 (4.1.4), compressed near the largest possible difference.
Plane colour_errors(const Planes& a, const Planes& b) {
  constexpr float kPower = 0.7F, kBend = 0.4F, kBentTo = 0.95F;
  const Plane zero = Plane::Zero(1, 1), one = Plane::Ones(1, 1);
  const float most = std::pow(hyab(lab_of({zero, one, zero}), lab_of({zero, zero, one}))(0, 0), kPower);
  const float bend = kBend * most;
  const Plane apart = hyab(lab_of(a), lab_of(b)).pow(kPower);
  return (apart < bend)
      .select(apart * (kBentTo / bend), kBentTo + (apart - bend) * ((1.0F - kBentTo) / (most - bend)));
}

}  // namespace

double flip(const Image& rendered, const Image& truth) {
  check_pair("flip", rendered, truth, 1);
  if (truth.channels != 3) return std::numeric_limits<double>::quiet_NaN();
  const Planes a = times(opponent_from_rgb(), linear(rendered, truth));
  const Planes b = times(opponent_from_rgb(), linear(truth, truth));
  const auto [edges_a, points_a] = features(a[0]);
  const auto [edges_b, points_b] = features(b[0]);
  const Plane of_features =
      ((edges_a - edges_b).abs().max((points_a - points_b).abs()) / std::sqrt(2.0F)).sqrt();
  const Plane errors = colour_errors(seen(a), seen(b)).pow(1.0F - of_features);
  double sum = 0.0;
  std::size_t known = 0;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      if (truth.at(x, y, 0) < 0.0F) continue;
      sum += static_cast<double>(errors(x, y));
      ++known;
    }
  }
  return sum / static_cast<double>(known);
}

}  // namespace simuli
