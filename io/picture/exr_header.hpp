#pragma once
#include <filesystem>

namespace simuli {

/// Throws Error{kInput} naming `file` for an OpenEXR header that claims too much: an attribute longer than the
/// file, pictures or tiles above the size limit, several parts. OpenEXR allocates the claimed size.
void require_sound_exr_header(const std::filesystem::path& file);

}  // namespace simuli
