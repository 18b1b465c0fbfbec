#pragma once
#include <filesystem>
#include <string_view>

namespace simuli {

/// The file that a `field` of `file` names by a path relative to `folder`. Error{kInput} when it lies
/// elsewhere: an absolute path, one with "..", or a symbolic link that leads out. Folders come as archives
/// from anybody. Whether it is there is not looked at.
[[nodiscard]] std::filesystem::path inside(const std::filesystem::path& folder,
                                           const std::filesystem::path& path,
                                           std::string_view file,
                                           std::string_view field);

/// The same for data sets whose folders are usually links to another disk: the path alone is looked at.
[[nodiscard]] std::filesystem::path below(const std::filesystem::path& folder,
                                          const std::filesystem::path& path,
                                          std::string_view file,
                                          std::string_view field);

}  // namespace simuli
