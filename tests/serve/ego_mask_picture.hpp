#pragma once
#include <filesystem>
#include <string>

namespace simuli::test {

/// A picture of 2 x 2 pixels with alpha, and the folder for it: opaque red and half white on top, nothing
/// below.
void write_ego_mask(const std::filesystem::path& file);

/// A stored picture's 8-bit values: [height][width][channels], by the library that writes pictures, which
/// reads formats that the program does not.
[[nodiscard]] std::string stored_bytes(const std::filesystem::path& file);

}  // namespace simuli::test
