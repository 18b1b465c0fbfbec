#pragma once
#include <filesystem>
#include <string>

namespace simuli {

/// ".mcap" of A.MCAP: cards and other systems write names in capitals.
[[nodiscard]] std::string ending_of(const std::filesystem::path& file);

}  // namespace simuli
