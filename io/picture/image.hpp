#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "host/core/base/image.hpp"

namespace simuli {

/// Largest side of a JPEG; libjpeg terminates the process beyond it.
inline constexpr int kMostJpeg_px = 65500;

/// Reads PNG, JPEG, EXR, ... as float RGB (grey is replicated, alpha dropped). Throws Error{kInput} naming file
/// and cause for a truncated or unreadable file and for sides above 65 536 pixels.
[[nodiscard]] Image read_image(const std::filesystem::path& file);
/// Reads a picture with opacity as fourth channel, 1 without alpha in the file; colours as stored, not
/// multiplied by alpha.
[[nodiscard]] Image read_image_with_alpha(const std::filesystem::path& file);
/// Writes 8-bit (PNG, JPEG) or float (EXR) by extension, atomically; 1 or 3 channels; 8-bit formats clip values
/// to [0,1].
void write_image(const std::filesystem::path& file, const Image& image);
/// Writes integers from 0 to 65535 with 1 or 3 channels as a 16-bit PNG. Throws Error{kInput} for other values.
void write_counts(const std::filesystem::path& file, const Image& image);
enum class ImageCode {
  kPng,
  kJpeg,
  kJpeg2000  // lossless; sides of at least 32 pixels
};
/// Returns the bytes of an 8-bit file as in write_image(); `quality` of JPEG in [1, 100].
[[nodiscard]] std::string encode_image(const Image& image, ImageCode code, int quality = 90);
/// The same for 8-bit pixels [height][width][3].
[[nodiscard]] std::string encode_pixels(
    std::span<const unsigned char> pixels, int width, int height, ImageCode code, int quality = 90);
/// Converts `values` to 8 bits: clipped to [0, 1], rounded to the nearest of 255 steps. Throws Error{kUsage}
/// for different lengths.
void to_bytes(std::span<const float> values, std::span<unsigned char> bytes);
/// Resizes by area averaging (box filter over the exact footprint of each new pixel).
[[nodiscard]] Image resize_area(const Image& image, int width, int height);

}  // namespace simuli
