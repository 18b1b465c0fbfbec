#pragma once
#include <filesystem>

namespace simuli {

/// Whether the name exists, including dangling and cyclic links.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

/// Throws Error{kInput} for folders, pipes and devices: libraries that open files by name would wait for a pipe
/// and read a device without end, and writing would replace a device. Ignores missing files.
void need_regular_file(const std::filesystem::path& file);

}  // namespace simuli
