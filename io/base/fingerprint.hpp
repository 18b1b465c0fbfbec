#pragma once
#include <filesystem>
#include <string>

namespace simuli {

/// Tells whether a file, or anything in a folder, is another than before, as build tools do: from names,
/// sizes and times of last change, without reading what is in them. "3 files, 1200 bytes, 0123456789abcdef";
/// empty where there is nothing of that name. Locks and temporaries (io/base) count as nothing.
/// Error{kInput} for a folder that can't be read.
[[nodiscard]] std::string fingerprint(const std::filesystem::path& path);

}  // namespace simuli
