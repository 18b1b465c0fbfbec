#include "host/cli/report/pair_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/cli/base/pictures.hpp"

namespace simuli::cli {

PicturePair range_pictures(const LidarModel& lidar, const LidarPair& sweep) {
  return {range_image(lidar, sweep.rendered.rays, sweep.rendered.range),
          range_image(lidar, sweep.recorded.rays, sweep.recorded.range)};
}

Image error_picture(const PicturePair& pair) {
  Image out(pair.rendered.width, pair.rendered.height, 3);
  for (std::size_t i = 0; i < out.data.size(); i += 3) {
    float sum = 0.0F;
    for (std::size_t c = 0; c < 3; ++c) {
      sum += std::abs(pair.rendered.data[i + c] - pair.recorded.data[i + c]);
    }
    const auto place = static_cast<double>(kErrorGain * sum / 3.0F);
    const std::array<float, 3> colour = colour_at(1.0 - place);
    // From black, so that what is right is dark.
    for (std::size_t c = 0; c < 3; ++c) {
      out.data[i + c] = colour[c] * static_cast<float>(std::min(1.0, place));
    }
  }
  return out;
}

Image birds_eye(const LidarModel& lidar, const LidarPair& sweep, double radius_m) {
  constexpr int kSide_px = 900;
  constexpr std::array<float, 3> kRecorded{0.16F, 0.47F, 1.0F}, kRendered{0.84F, 0.53F, 0.0F};
  Image out(kSide_px, kSide_px, 3);
  const auto draw = [&](const std::vector<float>& range, const std::array<float, 3>& colour) {
    std::vector<bool> drawn(static_cast<std::size_t>(kSide_px) * kSide_px);
    for (std::size_t i = 0; i < range.size(); ++i) {
      if (!(range[i] > 0.0F)) continue;
      const Eigen::Vector3d p = ray_origin(lidar, sweep.recorded.rays, i) +
                                static_cast<double>(range[i]) *
                                    Lidar::direction(static_cast<double>(sweep.recorded.rays.azimuth[i]),
                                                     static_cast<double>(sweep.recorded.rays.elevation[i]));
      const auto x = static_cast<int>(std::floor((p.x() / radius_m + 1.0) * 0.5 * kSide_px));
      const auto y = static_cast<int>(std::floor((1.0 - p.y() / radius_m) * 0.5 * kSide_px));
      if (x < 0 || x >= kSide_px || y < 0 || y >= kSide_px) continue;
      const std::size_t pixel = static_cast<std::size_t>(y) * kSide_px + static_cast<std::size_t>(x);
      if (drawn[pixel]) continue;
      drawn[pixel] = true;
      for (std::size_t c = 0; c < 3; ++c) {
        float& value = out.data[3 * pixel + c];
        value = std::min(1.0F, value + colour[c]);
      }
    }
  };
  draw(sweep.recorded.range, kRecorded);
  draw(sweep.rendered.range, kRendered);
  return out;
}

std::vector<std::size_t> some_of(const std::vector<std::size_t>& frames, std::size_t count) {
  if (frames.size() <= count) return frames;
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < count; ++k) out.push_back(frames[(2 * k + 1) * frames.size() / (2 * count)]);
  return out;
}

}  // namespace simuli::cli
