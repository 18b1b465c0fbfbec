#pragma once
// Files of Gaussians in formats of other programs: 3DGS PLY (io/splat/ply.hpp), SuperSplat's compressed PLY,
// Niantic's SPZ, glTF and OpenUSD. The axes of PLY are right, down, forward, of SPZ right, up, back, of glTF
// left, up, forward; USD specifies its own. Conversions change signs such that a model has the same particles
// in every format.
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// Up axis of a model: y down (x right, z forward), the most common; y up (z backward); z up (x forward, y
/// left), as in a scene's world.
enum class SplatAxes { kYDown, kYUp, kZUp };

/// Options of written splats.
struct SplatOutput {
  SplatAxes axes = SplatAxes::kYDown;  // of the set; it is rotated to the file's axes, except for PLY
  bool compress = false;               // .glb: particles as SPZ, which rounds them
};

/// Properties of a splat file besides its particles.
struct SplatReport {
  Eigen::Index left_out = 0;  // particles with NaN, Inf or a zero quaternion
  /// Whether opacities account for the widening by a pixel's footprint (antialiased). Only SPZ specifies this.
  bool is_antialiased = false;
  /// Returns one line per note.
  [[nodiscard]] std::vector<std::string> notes() const;
};
/// Returns a message on the particles left out: "2 particles with NaN, Inf or a zero quaternion".
[[nodiscard]] std::string broken_particles(Eigen::Index count);

/// Reads a camera set with y down: .spz and .glb by extension, otherwise any PLY. An infinite opacity logit
/// becomes 1. Particles with NaN, Inf or a zero quaternion are left out and counted in `report`, or refused
/// without it. Throws Error{kInput} as the readers below, and if no particle is left.
[[nodiscard]] GaussianSet read_splats(const std::filesystem::path& file, SplatReport* report = nullptr);
/// The same for the bytes of a file of that name.
[[nodiscard]] GaussianSet read_splats(std::string bytes,
                                      const std::filesystem::path& file,
                                      SplatReport* report = nullptr);
/// Writes .ply, .spz, .glb, .usda or .usdz by extension, atomically. Throws Error{kInput} for other extensions
/// and for sets that the format does not support.
void write_splats(const std::filesystem::path& file, const GaussianSet& set, const SplatOutput& how = {});
/// Whether read_splats() reads files with this extension: .ply, .spz or .glb.
[[nodiscard]] bool has_splat_extension(const std::filesystem::path& file);
/// Whether the extension is that of an unsupported splat format: .splat, .ksplat, .sog.
[[nodiscard]] bool has_other_splat_extension(const std::filesystem::path& file);
/// ".ply, .spz or .glb", for messages.
inline constexpr char kSplatExtensions[] = ".ply, .spz or .glb";

/// Whether these are the first bytes of a compressed PLY.
[[nodiscard]] bool is_compressed_ply(const std::string& bytes);
/// Reads SuperSplat's compressed PLY (PlayCanvas; little endian): chunks of 256 with bounds, positions and
/// log-scales of 11, 10, 11 bits, the three smaller quaternion components of 10 bits, colours and opacities of
/// 8 bits, higher SH coefficients of 8 bits within -4 to 4. Throws Error{kInput} naming file and field for
/// inconsistent elements, sizes and bounds; does not validate() particles.
[[nodiscard]] GaussianSet read_compressed_ply(const std::string& bytes, const std::string& file);

/// Reads SPZ versions 1 to 4 (4 if libzstd was available at build time), compressed or raw: positions of 24
/// bits, log-scales in steps of 1/16, quaternions of 8 bits or (from version 3) 10 bits, other values of 8
/// bits. Sizes are checked before allocation. Throws Error{kInput} naming file and field. Skips extensions of
/// version 4; reduces SH degree 4 to 3. Does not validate() particles.
[[nodiscard]] GaussianSet read_spz(const std::filesystem::path& file);
/// The same for the bytes of a file; `file` appears in messages.
[[nodiscard]] GaussianSet read_spz(std::string bytes, const std::string& file, SplatReport* report = nullptr);
/// Writes version 3 of a set with y down. Clips values to the format's range: colours to -0.4 to 1.4, SH to -1
/// to 1, scales to 45 um to 380 m. Throws the errors of validate(), and Error{kInput} for LiDAR sets and for
/// means so large that fewer than 4 fractional bits would remain (half a million metres).
void write_spz(const std::filesystem::path& file, const GaussianSet& set);

/// Reads a binary glTF 2.0 file: the particles of all primitives with KHR_gaussian_splatting (kernel "ellipse",
/// colour space "srgb_rec709_display") of its default scene, transformed by the nodes; floats and the allowed
/// normalised integers, and the draft KHR_gaussian_splatting_compression_spz_2, whose values are interpreted in
/// glTF's axes, as in CesiumJS. Throws Error{kInput} naming file and field for other kernels and colour spaces,
/// external files, sparse accessors, sheared or unevenly scaled nodes, and invalid data.
[[nodiscard]] GaussianSet read_glb(const std::string& bytes,
                                   const std::string& file,
                                   SplatReport* report = nullptr);
/// Returns the bytes of such a file: one primitive, floats, COLOR_0 for viewers without splat support;
/// compress: SPZ 3. Throws the errors of validate(), and Error{kInput} for LiDAR sets and more than 4 GiB.
[[nodiscard]] std::string glb_of(const GaussianSet& set, const SplatOutput& how, const std::string& file);

/// A .usdz is a StoredZip whose first file is its layer.
inline constexpr std::size_t kUsdzAlignment = 64;
inline constexpr char kUsdzLayer[] = "splats.usda";
/// Returns an OpenUSD layer (.usda): one ParticleField3DGaussianSplat "Splats" in metres, z up for a set with z
/// up, else y up. Errors as in glb_of().
[[nodiscard]] std::string usda_of(const GaussianSet& set, SplatAxes axes, const std::string& file);

}  // namespace simuli
