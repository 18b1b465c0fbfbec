#pragma once
#include <filesystem>

namespace simuli::test {

/// A picture of 2 x 2 pixels with alpha, and the folder for it: opaque red and half white on top, nothing below.
void write_hood(const std::filesystem::path& file);

}  // namespace simuli::test
