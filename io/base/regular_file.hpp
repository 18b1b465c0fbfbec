#pragma once
#include <filesystem>

namespace simuli {

/// Whether there is something of that name: links that lead nowhere or round are, too.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

/// Error{kInput} for folders, pipes and devices: libraries that open files by name wait for a pipe, and read
/// a device without end; what replaces a file would replace a device. What is not there is left to whoever
/// opens it.
void need_regular_file(const std::filesystem::path& file);

}  // namespace simuli
