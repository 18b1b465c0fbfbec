#include "host/cli/base/pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <variant>

#include "host/base/error.hpp"

namespace simuli::cli {
namespace {

/// Colours from near to far, interpolated linearly; each neighbour differs in hue and in lightness.
constexpr std::array<std::array<float, 3>, 6> kRangeColours = {{{1.00F, 0.97F, 0.75F},
                                                                {0.99F, 0.75F, 0.25F},
                                                                {0.91F, 0.36F, 0.26F},
                                                                {0.62F, 0.18F, 0.50F},
                                                                {0.27F, 0.25F, 0.66F},
                                                                {0.12F, 0.45F, 0.60F}}};

}  // namespace

std::array<float, 3> colour_at(double place) {
  const double step = std::clamp(place, 0.0, 1.0) * (kRangeColours.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(step), kRangeColours.size() - 2);
  const auto share = static_cast<float>(step - static_cast<double>(low));
  std::array<float, 3> out{};
  for (std::size_t c = 0; c < 3; ++c) {
    out[c] = (1.0F - share) * kRangeColours[low][c] + share * kRangeColours[low + 1][c];
  }
  return out;
}

namespace {

/// Colours of ranges, on a logarithmic scale.
class RangeScale {
 public:
  explicit RangeScale(const LidarModel& lidar)
      : nearest_m_(std::max(range_min(lidar), 0.5)), decades_(std::log(range_max(lidar) / nearest_m_)) {}
  std::array<float, 3> operator()(float range) const {
    return colour_at(std::log(static_cast<double>(range) / nearest_m_) / decades_);
  }

 private:
  double nearest_m_, decades_;
};

void set_pixel(Image& image, int x, int y, const std::array<float, 3>& colour) {
  for (int c = 0; c < 3; ++c) image.at(x, y, c) = colour[static_cast<std::size_t>(c)];
}

Image rows_image(const Lidar& lidar, const std::vector<float>& range, const RangeScale& scale) {
  const int columns = static_cast<int>(range.size() / lidar.rows.size());
  Image image(columns, lidar.row_count() * kBeam_px, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < columns; ++x) {
      // Azimuth grows to the left.
      const int column = lidar.spin == SpinDirection::kClockwise ? x : columns - 1 - x;
      const auto ray = static_cast<std::size_t>(y / kBeam_px) * static_cast<std::size_t>(columns) +
                       static_cast<std::size_t>(column);
      if (range[ray] > 0.0F) set_pixel(image, x, y, scale(range[ray]));
    }
  }
  return image;
}

Image list_image(const LidarRays& rays, const std::vector<float>& range, const RangeScale& scale) {
  constexpr double kPixels = 4.0;  // per ray, which is drawn as 2 x 2
  constexpr double kWidest_px = 4096.0;
  constexpr double kNarrowest_rad = 1e-3;
  double sine = 0.0, cosine = 0.0;
  for (const float azimuth : rays.azimuth) {
    sine += std::sin(static_cast<double>(azimuth));
    cosine += std::cos(static_cast<double>(azimuth));
  }
  const double middle = std::atan2(sine, cosine);
  std::vector<double> left, up;  // rad, of the middle
  for (std::size_t i = 0; i < range.size(); ++i) {
    left.push_back(std::remainder(static_cast<double>(rays.azimuth[i]) - middle, 2.0 * std::numbers::pi));
    up.push_back(static_cast<double>(rays.elevation[i]));
  }
  const auto [right_end, left_end] = std::minmax_element(left.begin(), left.end());
  const auto [low_end, high_end] = std::minmax_element(up.begin(), up.end());
  const double width = std::max(*left_end - *right_end, kNarrowest_rad);
  const double height = std::max(*high_end - *low_end, kNarrowest_rad);
  const double px_per_rad =
      std::min(std::sqrt(kPixels * static_cast<double>(range.size()) / (width * height)),
               kWidest_px / std::max(width, height));
  const auto pixels = [px_per_rad](double angle) { return static_cast<int>(angle * px_per_rad); };
  std::vector<std::size_t> farthest_first(range.size());
  std::iota(farthest_first.begin(), farthest_first.end(), std::size_t{0});
  std::stable_sort(farthest_first.begin(), farthest_first.end(), [&](std::size_t a, std::size_t b) {
    return range[a] > range[b];
  });
  Image image(pixels(width) + 2, pixels(height) + 2, 3);
  for (const std::size_t ray : farthest_first) {
    if (!(range[ray] > 0.0F)) continue;
    const int x = pixels(*left_end - left[ray]), y = pixels(*high_end - up[ray]);
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) set_pixel(image, x + dx, y + dy, scale(range[ray]));
    }
  }
  return image;
}

}  // namespace

Image range_image(const LidarModel& lidar, const LidarRays& rays, const std::vector<float>& range) {
  const RangeScale scale(lidar);
  const auto* const rows = std::get_if<Lidar>(&lidar);
  return rows == nullptr ? list_image(rays, range, scale) : rows_image(*rows, range, scale);
}

Image joined(const Image& first, const Image& second, Layout layout) {
  constexpr int kGap_px = 4;
  const bool beside = layout == Layout::kBeside;
  const bool fits = beside ? first.height == second.height : first.width == second.width;
  if (!fits || first.channels != 3 || second.channels != 3) {
    throw Error(ErrorKind::kInternal, "joined: pictures of different sizes");
  }
  Image out(beside ? first.width + kGap_px + second.width : first.width,
            beside ? first.height : first.height + kGap_px + second.height,
            3);
  std::fill(out.data.begin(), out.data.end(), 1.0F);
  const auto paste = [&out](const Image& from, int x0, int y0) {
    for (int y = 0; y < from.height; ++y) {
      for (int x = 0; x < from.width; ++x) {
        for (int c = 0; c < 3; ++c) out.at(x0 + x, y0 + y, c) = from.at(x, y, c);
      }
    }
  };
  paste(first, 0, 0);
  paste(second, beside ? first.width + kGap_px : 0, beside ? 0 : first.height + kGap_px);
  return out;
}

}  // namespace simuli::cli
