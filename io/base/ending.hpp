#pragma once
#include <filesystem>
#include <string>

namespace simuli {

/// Returns the extension in lower case: ".mcap" for A.MCAP.
[[nodiscard]] std::string ending_of(const std::filesystem::path& file);

}  // namespace simuli
