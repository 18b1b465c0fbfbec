#pragma once
#include <filesystem>
#include <string_view>

namespace simuli {

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
