#include "host/apps/cli/draw/depth_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "host/apps/cli/draw/pictures.hpp"

namespace simuli::cli {
namespace {

void paint(Image& image, std::size_t pixel, const std::array<float, 3>& colour) {
  std::copy(colour.begin(), colour.end(), image.data.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
}

Image black_of(const Frame& frame) {
  const Camera& camera = frame.sensor().camera();
  return {camera.width, camera.height, 3};
}

}  // namespace

Image opacity_picture(const Frame& frame) {
  Image image = black_of(frame);
  const RayResults& rays = frame.results();
  for (std::size_t i = 0; i < rays.rays; ++i) {
    const float taken = std::clamp(1.0F - rays.transmittance[i], 0.0F, 1.0F);
    paint(image, i, {taken, taken, taken});
  }
  return image;
}

DepthPicture depth_picture(const Frame& frame) {
  constexpr float kMostLeft = 0.5F;
  constexpr std::size_t kOneInEnds = 50;
  Image image = black_of(frame);
  const RayResults& rays = frame.results();
  const auto distance = [&](std::size_t i) {
    return rays.median.empty() ? rays.expected_distance(i) : rays.median[i];
  };
  const auto has_depth = [&](std::size_t i) {
    return rays.transmittance[i] <= kMostLeft && distance(i) > 0.0F;
  };
  std::vector<float> depths;
  for (std::size_t i = 0; i < rays.rays; ++i) {
    if (has_depth(i)) depths.push_back(distance(i));
  }
  if (depths.empty()) return {std::move(image)};
  std::sort(depths.begin(), depths.end());
  const std::size_t cut = depths.size() / kOneInEnds;
  // Powers of two keep the scale constant while the camera moves.
  const double low = std::floor(std::log2(static_cast<double>(depths[cut])));
  const double high =
      std::max(std::ceil(std::log2(static_cast<double>(depths[depths.size() - 1 - cut]))), low + 1.0);
  for (std::size_t i = 0; i < rays.rays; ++i) {
    if (!has_depth(i)) continue;
    paint(image, i, colour_at((std::log2(static_cast<double>(distance(i))) - low) / (high - low)));
  }
  return {std::move(image), std::exp2(low), std::exp2(high)};
}

}  // namespace simuli::cli
