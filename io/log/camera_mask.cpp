#include "io/log/camera_mask.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#include "io/picture/sized_image.hpp"

namespace simuli {

bool CameraMask::hides(int x, int y, int picture_width, int picture_height) const {
  const auto first = [](int at, int of, int all) { return static_cast<int>(std::int64_t{at} * all / of); };
  const auto last = [](int at, int of, int all) {
    return static_cast<int>((std::int64_t{at} + 1) * all / of +
                            ((std::int64_t{at} + 1) * all % of != 0 ? 1 : 0));
  };
  for (int v = first(y, picture_height, height); v < std::min(last(y, picture_height, height), height); ++v) {
    for (int u = first(x, picture_width, width); u < std::min(last(x, picture_width, width), width); ++u) {
      if (hidden[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(u)] != 0)
        return true;
    }
  }
  return false;
}

double CameraMask::hidden_share() const {
  const auto count = std::count_if(hidden.begin(), hidden.end(), [](std::uint8_t h) { return h != 0; });
  return static_cast<double>(count) / static_cast<double>(hidden.size());
}

void CameraMask::add(const CameraMask& other) {
  std::transform(hidden.begin(), hidden.end(), other.hidden.begin(), hidden.begin(), [](auto a, auto b) {
    return static_cast<std::uint8_t>(a | b);
  });
}

/// A mask in the size of the original photograph may accompany pictures that were made smaller.
static constexpr double kLargestMaskScale = 16.0;

CameraMask read_camera_mask(const std::filesystem::path& file, const Camera& camera) {
  const Image image = read_image(file, [&](int width, int height) {
    const double scale = static_cast<double>(width) / camera.width;
    const bool is_of_its_shape = std::abs(camera.height * scale - height) <= std::max(scale, 1.0);
    if (is_of_its_shape && scale <= kLargestMaskScale) return;
    throw_input_error(file.string(),
                      "size_px",
                      fmt::format("{} x {}", width, height),
                      fmt::format("{} x {} as camera {}, or of that shape and up to {} times as wide",
                                  camera.width,
                                  camera.height,
                                  camera.name,
                                  kLargestMaskScale));
  });
  CameraMask mask{camera.width, camera.height, {}};
  mask.hidden.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (int y = 0; y < camera.height; ++y) {
    const int v =
        static_cast<int>((2 * std::int64_t{y} + 1) * image.height / (2 * std::int64_t{camera.height}));
    for (int x = 0; x < camera.width; ++x) {
      const int u =
          static_cast<int>((2 * std::int64_t{x} + 1) * image.width / (2 * std::int64_t{camera.width}));
      mask.hidden.push_back(image.at(u, v, 0) > 0.0F ? 1 : 0);
    }
  }
  if (std::all_of(mask.hidden.begin(), mask.hidden.end(), [](std::uint8_t h) { return h != 0; })) {
    throw_input_error(file.string(), "mask", "all of the picture", "0 where the scene is seen");
  }
  return mask;
}

void hide(const CameraMask& mask, Image& picture) {
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (!mask.hides(x, y, picture.width, picture.height)) continue;
      const std::size_t at =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x);
      const auto channels = static_cast<std::size_t>(picture.channels);
      std::fill_n(picture.data.begin() + static_cast<std::ptrdiff_t>(at * channels), channels, kHiddenValue);
    }
  }
}

}  // namespace simuli
