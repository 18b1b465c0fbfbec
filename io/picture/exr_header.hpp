#pragma once
#include <filesystem>

namespace simuli {

/// Error{kInput} naming `file` for an OpenEXR file that claims more than it is: an attribute longer than the
/// file, a picture or tiles of more pixels a side than pictures have here, several parts. OpenEXR allocates
/// what a header claims.
void require_sound_exr_header(const std::filesystem::path& file);

}  // namespace simuli
