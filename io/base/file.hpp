#pragma once
#include <filesystem>
#include <functional>
#include <string>

namespace simuli {

/// Whole file as bytes; Error{kInput} when missing, a folder, unreadable or above max_bytes.
[[nodiscard]] std::string read_file(const std::filesystem::path& file,
                                    std::size_t max_bytes = std::size_t{4} << 30U);
/// Writes under a temporary name in the same folder, syncs, renames. Error{kInput} on failure, and
/// then no file of that name is left behind.
void write_file_atomically(const std::filesystem::path& file, const std::string& bytes);
/// The same for libraries that write by name: `write` gets the temporary path (same extension).
void write_atomically(const std::filesystem::path& file,
                      const std::function<void(const std::filesystem::path&)>& write);
/// The same for a folder that must not exist yet: `write` fills a temporary sibling folder, which is
/// renamed to `folder` when `write` returns and removed when it throws. Error{kInput} when `folder`
/// exists or cannot be made.
void write_folder_atomically(const std::filesystem::path& folder,
                             const std::function<void(const std::filesystem::path&)>& write);

}  // namespace simuli
