#pragma once
// Pictures whose size is known before they are read: one of another is refused by its header, as anybody's may take
// minutes and gigabytes to decode.
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include "io/picture/image.hpp"

namespace simuli {

/// Width and height in px that the header tells; no pixel is read.
[[nodiscard]] std::pair<int, int> size_of_image(const std::filesystem::path& file);
/// As read_image(); `need_size` throws, or the pixels are read.
[[nodiscard]] Image read_image(const std::filesystem::path& file,
                               const std::function<void(int width, int height)>& need_size);
/// Error{kInput} for another size than that of `whose`: "camera front".
[[nodiscard]] Image read_image(const std::filesystem::path& file,
                               int width,
                               int height,
                               const std::string& whose);

}  // namespace simuli
