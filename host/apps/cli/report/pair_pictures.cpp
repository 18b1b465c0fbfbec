#include <algorithm>
#include <array>
#include <cmath>

#include "host/apps/cli/draw/pictures.hpp"
#include "host/apps/cli/report/report_parts.hpp"

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
    const std::array<float, 3> colour = error_colour(kErrorGain * sum / 3.0F);
    std::copy(colour.begin(), colour.end(), out.data.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return out;
}

std::vector<std::size_t> some_of(const std::vector<std::size_t>& frames, std::size_t count) {
  if (frames.size() <= count) return frames;
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < count; ++k) out.push_back(frames[(2 * k + 1) * frames.size() / (2 * count)]);
  return out;
}

}  // namespace simuli::cli
