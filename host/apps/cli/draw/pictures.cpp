#include "host/apps/cli/draw/pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "host/apps/cli/draw/sweep_canvas.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {
namespace {

/// Colours from near to far, interpolated linearly; neighbours differ in hue and lightness.
constexpr std::array<std::array<float, 3>, 6> kRangeColours = {{{1.00F, 0.97F, 0.75F},
                                                                {0.99F, 0.75F, 0.25F},
                                                                {0.91F, 0.36F, 0.26F},
                                                                {0.62F, 0.18F, 0.50F},
                                                                {0.27F, 0.25F, 0.66F},
                                                                {0.12F, 0.45F, 0.60F}}};
constexpr std::array<float, 3> kNothing{0.0F, 0.0F, 0.0F};
constexpr std::array<float, 3> kDropped{0.20F, 0.45F, 1.0F}, kOfNothing{0.20F, 0.75F, 0.35F};

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

/// Colour scale of ranges, logarithmic.
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

/// Returns rays without a return first, then the others from far to near.
std::vector<std::size_t> drawing_order(const std::vector<float>& range) {
  std::vector<std::size_t> order(range.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto rank = [&](std::size_t ray) {
    return range[ray] > 0.0F ? range[ray] : std::numeric_limits<float>::infinity();
  };
  std::stable_sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
  return order;
}

}  // namespace

Image range_image(const LidarModel& lidar, const LidarRays& rays, const std::vector<float>& range) {
  const RangeScale scale(lidar);
  SweepCanvas canvas(lidar, rays);
  for (const std::size_t ray : drawing_order(range)) {
    if (range[ray] > 0.0F) {
      canvas.draw(ray, scale(range[ray]));
    } else if (!is_blind(lidar, rays, ray)) {
      canvas.draw(ray, kNothing);
    }
  }
  return std::move(canvas).finish();
}

Image range_error_image(const LidarModel& lidar,
                        const LidarRays& rays,
                        const std::vector<float>& range,
                        const std::vector<float>& truth) {
  SweepCanvas canvas(lidar, rays);
  for (const std::size_t ray : drawing_order(truth)) {
    const bool returns = range[ray] > 0.0F, returned = truth[ray] > 0.0F;
    if (!returns && !returned && is_blind(lidar, rays, ray)) continue;
    std::array<float, 3> colour = kNothing;
    if (returns != returned) {
      colour = returned ? kDropped : kOfNothing;
    } else if (returned) {
      colour = error_colour(std::abs(range[ray] - truth[ray]) / kFullError_m);
    }
    canvas.draw(ray, colour);
  }
  return std::move(canvas).finish();
}

std::array<float, 3> error_colour(float error) {
  const float place = std::min(error, 1.0F);
  std::array<float, 3> colour = colour_at(1.0 - static_cast<double>(place));
  for (float& value : colour) value *= place;  // black for no error
  return colour;
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
