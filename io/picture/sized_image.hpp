#pragma once
// Pictures of a known size: a picture of another size is refused by its header, because decoding an untrusted
// file may take minutes and gigabytes.
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include "io/picture/image.hpp"

namespace simuli {

/// Returns width and height in px from the header without reading pixels.
[[nodiscard]] std::pair<int, int> size_of_image(const std::filesystem::path& file);
/// read_image() that first calls `need_size`, which may throw.
[[nodiscard]] Image read_image(const std::filesystem::path& file,
                               const std::function<void(int width, int height)>& need_size);
/// Throws Error{kInput} for another size than that of `whose`, for example "camera front".
[[nodiscard]] Image read_image(const std::filesystem::path& file,
                               int width,
                               int height,
                               const std::string& whose);

}  // namespace simuli
