#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace simuli {

/// Interleaved float picture, row-major, top row first.
struct Image {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<float> data;  // [height][width][channels]; colours in [0,1] as stored in the file

  Image() = default;
  Image(int w, int h, int c)
      : width(w),
        height(h),
        channels(c),
        data(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c)) {}
  [[nodiscard]] float& at(int x, int y, int c) { return data[index(x, y, c)]; }
  [[nodiscard]] float at(int x, int y, int c) const { return data[index(x, y, c)]; }

 private:
  [[nodiscard]] std::size_t index(int x, int y, int c) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels) +
           static_cast<std::size_t>(c);
  }
};

/// Reads PNG, JPEG, EXR, ... as float RGB (grey is replicated, alpha dropped). A truncated or unreadable
/// file, or one of more than 65 536 pixels a side, is Error{kInput} naming file and cause.
[[nodiscard]] Image read_image(const std::filesystem::path& file);
/// Writes 8-bit (PNG, JPEG) or float (EXR) by extension; 1 or 3 channels; values outside [0,1] are
/// clipped in 8-bit formats. Temporary name, then rename: never half-written.
void write_image(const std::filesystem::path& file, const Image& image);
enum class ImageCode { kPng, kJpeg };
/// The bytes of an 8-bit file of that format, as write_image() would write it; `quality` of JPEG in [1, 100].
[[nodiscard]] std::string encode_image(const Image& image, ImageCode code, int quality = 90);
/// Area-averaging resize (box filter over the exact footprint of each new pixel).
[[nodiscard]] Image resize_area(const Image& image, int width, int height);

}  // namespace simuli
