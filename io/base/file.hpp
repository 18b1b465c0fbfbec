#pragma once
#include <filesystem>
#include <functional>
#include <string>

namespace simuli {

/// Returns the whole file as bytes. Throws Error{kInput} if it is missing, a folder, unreadable or larger than
/// max_bytes.
[[nodiscard]] std::string read_file(const std::filesystem::path& file,
                                    std::size_t max_bytes = std::size_t{4} << 30U);
/// Writes a temporary file in the same folder, syncs and renames it. Throws Error{kInput} on failure; then the
/// temporary file is removed.
void write_file_atomically(const std::filesystem::path& file, const std::string& bytes);
/// write_file_atomically() for libraries that write to a path: `write` receives the temporary path with the
/// same extension.
void write_atomically(const std::filesystem::path& file,
                      const std::function<void(const std::filesystem::path&)>& write);
/// write_atomically() for a folder that must not exist: `write` fills a temporary sibling folder, which is
/// renamed to `folder` when `write` returns and removed when it throws. Throws Error{kInput} if `folder` exists
/// or cannot be created.
void write_folder_atomically(const std::filesystem::path& folder,
                             const std::function<void(const std::filesystem::path&)>& write);

}  // namespace simuli
