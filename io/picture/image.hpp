#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "host/core/base/image.hpp"

namespace simuli {

/// Largest side of a JPEG: libjpeg ends the process beyond it.
inline constexpr int kMostJpeg_px = 65500;

/// Reads PNG, JPEG, EXR, ... as float RGB (grey is replicated, alpha dropped). A truncated or unreadable
/// file, or one of more than 65 536 pixels a side, is Error{kInput} naming file and cause.
[[nodiscard]] Image read_image(const std::filesystem::path& file);
/// The same with how opaque each pixel is as fourth channel, 1 where the file doesn't say; colours as stored,
/// not multiplied by it.
[[nodiscard]] Image read_image_with_alpha(const std::filesystem::path& file);
/// Writes 8-bit (PNG, JPEG) or float (EXR) by extension; 1 or 3 channels; values outside [0,1] are
/// clipped in 8-bit formats. Temporary name, then rename: never half-written.
void write_image(const std::filesystem::path& file, const Image& image);
/// Whole numbers, 0 to 65535, of 1 or 3 channels as a PNG of 16 bits. Error{kInput} for others.
void write_counts(const std::filesystem::path& file, const Image& image);
enum class ImageCode {
  kPng,
  kJpeg,
  kJpeg2000  // without loss; of 32 pixels a side and more
};
/// The bytes of an 8-bit file of that format, as write_image() would write it; `quality` of JPEG in [1, 100].
[[nodiscard]] std::string encode_image(const Image& image, ImageCode code, int quality = 90);
/// The same of what is 8-bit already: [height][width][3].
[[nodiscard]] std::string encode_pixels(
    std::span<const unsigned char> pixels, int width, int height, ImageCode code, int quality = 90);
/// `values` as 8-bit formats hold them: clipped to [0, 1], the nearest of 255 steps. As many bytes;
/// Error{kUsage} for another number of them.
void to_bytes(std::span<const float> values, std::span<unsigned char> bytes);
/// Area-averaging resize (box filter over the exact footprint of each new pixel).
[[nodiscard]] Image resize_area(const Image& image, int width, int height);

}  // namespace simuli
