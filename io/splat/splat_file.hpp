#pragma once
// Files of Gaussians as other programs write them: the 3DGS PLY (io/splat/ply.hpp), SuperSplat's compressed
// PLY, and Niantic's SPZ. The axes of SPZ are right, up, back, those of the PLYs right, down, forward: y and
// z change sign on the way, so that the same model has the same particles whichever file it comes from.
#include <filesystem>
#include <string>

#include "host/scene/gaussians.hpp"

namespace simuli {

/// Reads a camera set: .spz by that extension, any PLY else. Error{kInput} as the readers below say.
[[nodiscard]] GaussianSet read_splats(const std::filesystem::path& file);
/// The same of the bytes of a file of that name.
[[nodiscard]] GaussianSet read_splats(std::string bytes, const std::filesystem::path& file);
/// Writes .ply or .spz by extension. Error{kInput} for another one.
void write_splats(const std::filesystem::path& file, const GaussianSet& set);

/// Whether these are the first bytes of a compressed PLY.
[[nodiscard]] bool is_compressed_ply(const std::string& bytes);
/// SuperSplat's compressed PLY (PlayCanvas; little endian): chunks of 256 with their bounds, positions and
/// log-scales of 11, 10, 11 bits, the three smaller quaternion components of 10 bits, colours and opacities
/// of 8, higher SH coefficients of 8 within -4 to 4. Error{kInput} naming file and field for elements, sizes
/// and bounds that don't belong together.
[[nodiscard]] GaussianSet read_compressed_ply(const std::string& bytes, const std::string& file);

/// SPZ versions 1 to 4 (4 where libzstd was there at build time), compressed or raw: positions of 24 bits,
/// log-scales of 1/16, quaternions of 8 bits or (from version 3) of 10, everything else of 8. Sizes are
/// checked before anything is allocated. Error{kInput} naming file and field. Extensions of version 4 are
/// skipped; SH degree 4 is cut to 3.
[[nodiscard]] GaussianSet read_spz(const std::filesystem::path& file);
/// The same of its bytes; `file` is for messages.
[[nodiscard]] GaussianSet read_spz(std::string bytes, const std::string& file);
/// Version 3. What its numbers can't hold is clipped: colours to -0.4 to 1.4, SH to -1 to 1, scales to
/// 45 um to 380 m. Error{kInput} for what validate() refuses, for LiDAR sets, and for means so far out that
/// fewer than 4 fractional bits would be left (half a million metres).
void write_spz(const std::filesystem::path& file, const GaussianSet& set);

}  // namespace simuli
