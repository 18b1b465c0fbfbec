#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

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

/// Whether the name exists, including dangling and cyclic links.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

/// Throws Error{kInput} for folders, pipes and devices: libraries that open files by name would wait for a pipe
/// and read a device without end, and writing would replace a device. Ignores missing files.
void need_regular_file(const std::filesystem::path& file);

/// Returns the extension in lower case: ".mcap" for A.MCAP.
[[nodiscard]] std::string ending_of(const std::filesystem::path& file);

/// Returns the file that `field` of `file` names by a path relative to `folder`. Throws Error{kInput} for a
/// path outside the folder: absolute, with "..", or through a symbolic link. This protects against hostile
/// archives. The file need not exist.
[[nodiscard]] std::filesystem::path inside(const std::filesystem::path& folder,
                                           const std::filesystem::path& path,
                                           std::string_view file,
                                           std::string_view field);

/// The same for data sets whose folders are often links to another disk: checks the path without resolving
/// links.
[[nodiscard]] std::filesystem::path below(const std::filesystem::path& folder,
                                          const std::filesystem::path& path,
                                          std::string_view file,
                                          std::string_view field);

}  // namespace simuli
