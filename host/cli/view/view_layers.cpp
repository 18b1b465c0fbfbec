#include "host/cli/view/view_layers.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/cli/base/pictures.hpp"

namespace simuli::cli {
namespace {

void paint(Image& image, std::size_t pixel, const std::array<float, 3>& colour) {
  std::copy(colour.begin(), colour.end(), image.data.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
}

LayerPicture opacity_of(const RayResults& rays, Image image) {
  for (std::size_t i = 0; i < rays.rays; ++i) {
    const float taken = std::clamp(1.0F - rays.transmittance[i], 0.0F, 1.0F);
    paint(image, i, {taken, taken, taken});
  }
  return {std::move(image)};
}

LayerPicture depth_of(const RayResults& rays, Image image) {
  constexpr float kMostLeft = 0.5F;
  constexpr std::size_t kOneInEnds = 50;
  const auto is_met = [&](std::size_t i) { return rays.transmittance[i] <= kMostLeft; };
  std::vector<float> met;
  for (std::size_t i = 0; i < rays.rays; ++i) {
    if (is_met(i)) met.push_back(rays.expected_distance(i));
  }
  if (met.empty()) return {std::move(image)};
  std::sort(met.begin(), met.end());
  const std::size_t cut = met.size() / kOneInEnds;
  // Whole powers: the scale stays as it is while the camera moves on.
  const double low = std::floor(std::log2(static_cast<double>(met[cut])));
  const double high =
      std::max(std::ceil(std::log2(static_cast<double>(met[met.size() - 1 - cut]))), low + 1.0);
  for (std::size_t i = 0; i < rays.rays; ++i) {
    if (!is_met(i)) continue;
    paint(image,
          i,
          colour_at((std::log2(static_cast<double>(rays.expected_distance(i))) - low) / (high - low)));
  }
  return {std::move(image), std::exp2(low), std::exp2(high)};
}

}  // namespace

LayerPicture layer_of(ViewLayer layer, const Frame& frame) {
  if (layer == ViewLayer::kColour) return {frame.image()};
  const Sensor& camera = frame.sensor();
  Image black(static_cast<int>(camera.columns()), static_cast<int>(camera.rows()), 3);
  const RayResults& rays = frame.results();
  return layer == ViewLayer::kDepth ? depth_of(rays, std::move(black)) : opacity_of(rays, std::move(black));
}

}  // namespace simuli::cli
