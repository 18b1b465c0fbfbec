// Pixels of sensor_msgs/Image in its encodings (sensor_msgs/image_encodings.hpp).
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/core/base/error.hpp"
#include "io/import/ros2/ros2_frames.hpp"

namespace simuli::ros2 {
namespace {

enum class Layout {
  kColours,  // red, green and blue of each pixel at `place`
  kMosaic,   // one colour per pixel: `place` contains the colours of a square of 2 x 2
  kPairs,    // luma of two pixels at `place[0]` and two bytes later, their U and V at place[1], place[2]
  kPlanes,   // luma, followed by a row of U and V per two rows, at `place[1]` and `place[2]` of two bytes
};

struct Encoding {
  std::string_view name;
  Layout layout;
  std::size_t bytes;  // per value: 1 or 2
  std::size_t values;
  std::array<std::size_t, 4> place;
};
constexpr std::size_t kR = 0, kG = 1, kB = 2;
constexpr Encoding kEncodings[] = {
    {"rgb8", Layout::kColours, 1, 3, {0, 1, 2}},
    {"bgr8", Layout::kColours, 1, 3, {2, 1, 0}},
    {"rgba8", Layout::kColours, 1, 4, {0, 1, 2}},
    {"bgra8", Layout::kColours, 1, 4, {2, 1, 0}},
    {"mono8", Layout::kColours, 1, 1, {0, 0, 0}},
    {"8UC1", Layout::kColours, 1, 1, {0, 0, 0}},  // interpreted as in cv_bridge
    {"8UC3", Layout::kColours, 1, 3, {2, 1, 0}},
    {"8UC4", Layout::kColours, 1, 4, {2, 1, 0}},
    {"rgb16", Layout::kColours, 2, 3, {0, 1, 2}},
    {"bgr16", Layout::kColours, 2, 3, {2, 1, 0}},
    {"rgba16", Layout::kColours, 2, 4, {0, 1, 2}},
    {"bgra16", Layout::kColours, 2, 4, {2, 1, 0}},
    {"mono16", Layout::kColours, 2, 1, {0, 0, 0}},
    {"bayer_rggb8", Layout::kMosaic, 1, 1, {kR, kG, kG, kB}},
    {"bayer_bggr8", Layout::kMosaic, 1, 1, {kB, kG, kG, kR}},
    {"bayer_gbrg8", Layout::kMosaic, 1, 1, {kG, kB, kR, kG}},
    {"bayer_grbg8", Layout::kMosaic, 1, 1, {kG, kR, kB, kG}},
    {"bayer_rggb16", Layout::kMosaic, 2, 1, {kR, kG, kG, kB}},
    {"bayer_bggr16", Layout::kMosaic, 2, 1, {kB, kG, kG, kR}},
    {"bayer_gbrg16", Layout::kMosaic, 2, 1, {kG, kB, kR, kG}},
    {"bayer_grbg16", Layout::kMosaic, 2, 1, {kG, kR, kB, kG}},
    {"yuv422", Layout::kPairs, 1, 2, {1, 0, 2}},  // UYVY
    {"uyvy", Layout::kPairs, 1, 2, {1, 0, 2}},
    {"yuv422_yuy2", Layout::kPairs, 1, 2, {0, 1, 3}},  // YUYV
    {"yuyv", Layout::kPairs, 1, 2, {0, 1, 3}},
    {"nv21", Layout::kPlanes, 1, 1, {0, 1, 0}},
    {"nv12", Layout::kPlanes, 1, 1, {0, 0, 1}}};

class Pixels {
 public:
  Pixels(const ImageMessage& message, const Encoding& encoding) : m_(message), e_(encoding) {}

  /// Returns a colour in 0 to 1.
  [[nodiscard]] float colour(int x, int y, std::size_t c) const {
    switch (e_.layout) {
      case Layout::kColours:
        return value(y, static_cast<std::size_t>(x) * e_.values + e_.place[c]);
      case Layout::kMosaic:
        return mosaic(x, y, c);
      case Layout::kPairs: {
        const std::size_t pair = static_cast<std::size_t>(x / 2) * 4;
        return from_yuv(c,
                        value(y, static_cast<std::size_t>(x) * 2 + e_.place[0]),
                        value(y, pair + e_.place[1]),
                        value(y, pair + e_.place[2]));
      }
      default: {
        const int row = static_cast<int>(m_.height) + y / 2;
        const std::size_t pair = static_cast<std::size_t>(x / 2) * 2;
        return from_yuv(c,
                        value(y, static_cast<std::size_t>(x)),
                        value(row, pair + e_.place[1]),
                        value(row, pair + e_.place[2]));
      }
    }
  }

 private:
  [[nodiscard]] float value(int y, std::size_t at) const {
    const char* const place = m_.data.data() + static_cast<std::size_t>(y) * m_.step + at * e_.bytes;
    constexpr float kMost8 = 255.0F, kMost16 = 65535.0F;
    if (e_.bytes == 1) return static_cast<float>(static_cast<unsigned char>(*place)) / kMost8;
    const auto low = static_cast<unsigned char>(place[m_.is_bigendian ? 1 : 0]);
    const auto high = static_cast<unsigned char>(place[m_.is_bigendian ? 0 : 1]);
    return static_cast<float>(256 * high + low) / kMost16;
  }

  /// Returns the pixel's value of its own colour, else the mean of the neighbours with this colour.
  [[nodiscard]] float mosaic(int x, int y, std::size_t c) const {
    const auto measures = [&](int px, int py) {
      return e_.place[static_cast<std::size_t>(py % 2 * 2 + px % 2)];
    };
    if (measures(x, y) == c) return value(y, static_cast<std::size_t>(x));
    float sum = 0.0F, count = 0.0F;
    for (int py = std::max(0, y - 1); py <= std::min(static_cast<int>(m_.height) - 1, y + 1); ++py) {
      for (int px = std::max(0, x - 1); px <= std::min(static_cast<int>(m_.width) - 1, x + 1); ++px) {
        if (measures(px, py) != c) continue;
        sum += value(py, static_cast<std::size_t>(px));
        count += 1.0F;
      }
    }
    return count > 0.0F ? sum / count : 0.0F;
  }

  /// ITU-R BT.601 with luma of 16 to 235, as in cameras and cv_bridge.
  static float from_yuv(std::size_t c, float y, float u, float v) {
    const float luma = 1.164F * (y - 16.0F / 255.0F), blue = u - 128.0F / 255.0F, red = v - 128.0F / 255.0F;
    const float colour = c == kR   ? luma + 1.596F * red
                         : c == kB ? luma + 2.018F * blue
                                   : luma - 0.813F * red - 0.391F * blue;
    return std::clamp(colour, 0.0F, 1.0F);
  }

  const ImageMessage& m_;
  const Encoding& e_;
};

const Encoding* find_encoding(std::string_view name) {
  const auto* const found = std::find_if(
      std::begin(kEncodings), std::end(kEncodings), [&](const Encoding& e) { return e.name == name; });
  return found == std::end(kEncodings) ? nullptr : found;
}

}  // namespace

bool is_known_encoding(std::string_view encoding) { return find_encoding(encoding) != nullptr; }

Image picture_of(const ImageMessage& message, const std::string& file, const std::string& where) {
  const Encoding* const encoding = find_encoding(message.encoding);
  if (encoding == nullptr) {
    std::vector<std::string_view> known;
    for (const Encoding& e : kEncodings) known.push_back(e.name);
    throw_input_error(
        file, where + ": encoding", '"' + message.encoding + '"', fmt::format("{}", fmt::join(known, ", ")));
  }
  const auto side = static_cast<std::uint32_t>(kLargestSide_px);
  if (message.width == 0 || message.height == 0 || message.width > side || message.height > side ||
      message.step < message.width * encoding->bytes * encoding->values) {
    throw_input_error(file,
                      where + ": width x height, step",
                      fmt::format("{} x {}, {}", message.width, message.height, message.step),
                      fmt::format("1 to {} a side, rows of whole pixels", kLargestSide_px));
  }
  const bool has_pairs = encoding->layout == Layout::kPairs, has_planes = encoding->layout == Layout::kPlanes;
  if ((has_pairs || has_planes) && (message.width % 2 != 0 || (has_planes && message.height % 2 != 0))) {
    throw_input_error(file,
                      where + ": width x height",
                      fmt::format("{} x {}", message.width, message.height),
                      fmt::format("even numbers, as {} has a colour for two pixels", message.encoding));
  }
  const std::uint64_t need =
      std::uint64_t{message.step} * (has_planes ? message.height * 3 / 2 : message.height);
  if (message.data.size() < need)
    throw_input_error(
        file, where + ": data", fmt::format("{} bytes", message.data.size()), fmt::format("{}", need));
  Image image(static_cast<int>(message.width), static_cast<int>(message.height), 3);
  const Pixels pixels(message, *encoding);
  float* to = image.data.data();
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) *to++ = pixels.colour(x, y, c);
    }
  }
  return image;
}

}  // namespace simuli::ros2
