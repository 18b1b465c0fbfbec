#pragma once
// Files of Gaussians as other programs write them: the 3DGS PLY (io/splat/ply.hpp), SuperSplat's compressed
// PLY, Niantic's SPZ, glTF and OpenUSD. The axes of PLYs are right, down, forward, those of SPZ right, up,
// back, those of glTF left, up, forward, USD says its own: signs change on the way, so that the same model
// has the same particles whichever file it comes from.
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// What is up in a model: y down (x right, z forward), as most programs write them; y up (z backward); z up
/// (x forward, y left), as in the world of a scene.
enum class SplatAxes { kYDown, kYUp, kZUp };

/// How splats are written.
struct SplatOutput {
  SplatAxes axes = SplatAxes::kYDown;  // of the set: it is turned to those of the file, but in a PLY
  bool compress = false;               // .glb: particles as SPZ in it, with what that rounds
};

/// What there is to know of a file of splats beside its particles.
struct SplatReport {
  Eigen::Index left_out = 0;  // particles with NaN, Inf or a zero quaternion
  /// Opacities are of splats which lose some where a pixel's footprint widens them. SPZ alone says so.
  bool is_antialiased = false;
  /// For people, a line each.
  [[nodiscard]] std::vector<std::string> notes() const;
};
/// Those that are left out, for messages: "2 particles with NaN, Inf or a zero quaternion".
[[nodiscard]] std::string broken_particles(Eigen::Index count);

/// Reads a camera set with y down: .spz and .glb by extension, any PLY else. An opacity of Inf is 1.
/// Particles with NaN, Inf or a zero quaternion are left out and told in `report`, or refused without it.
/// Error{kInput} as the readers below say, and where no particle is left.
[[nodiscard]] GaussianSet read_splats(const std::filesystem::path& file, SplatReport* report = nullptr);
/// The same of the bytes of a file of that name.
[[nodiscard]] GaussianSet read_splats(std::string bytes,
                                      const std::filesystem::path& file,
                                      SplatReport* report = nullptr);
/// Writes .ply, .spz, .glb, .usda or .usdz by extension, complete or not at all. Error{kInput} for another
/// one, and for what the format does not hold.
void write_splats(const std::filesystem::path& file, const GaussianSet& set, const SplatOutput& how = {});
/// Whether read_splats() takes files of that name: .ply, .spz or .glb.
[[nodiscard]] bool has_splat_extension(const std::filesystem::path& file);
/// Whether it is called as splats of formats that are not read are: .splat, .ksplat, .sog.
[[nodiscard]] bool has_other_splat_extension(const std::filesystem::path& file);
/// ".ply, .spz or .glb", for messages.
inline constexpr char kSplatExtensions[] = ".ply, .spz or .glb";

/// Whether these are the first bytes of a compressed PLY.
[[nodiscard]] bool is_compressed_ply(const std::string& bytes);
/// SuperSplat's compressed PLY (PlayCanvas; little endian): chunks of 256 with their bounds, positions and
/// log-scales of 11, 10, 11 bits, the three smaller quaternion components of 10 bits, colours and opacities
/// of 8, higher SH coefficients of 8 within -4 to 4. Error{kInput} naming file and field for elements, sizes
/// and bounds that don't belong together; particles are not judged (validate()).
[[nodiscard]] GaussianSet read_compressed_ply(const std::string& bytes, const std::string& file);

/// SPZ versions 1 to 4 (4 where libzstd was there at build time), compressed or raw: positions of 24 bits,
/// log-scales of 1/16, quaternions of 8 bits or (from version 3) of 10, everything else of 8. Sizes are
/// checked before anything is allocated. Error{kInput} naming file and field. Extensions of version 4 are
/// skipped; SH degree 4 is cut to 3. Particles are not judged (validate()).
[[nodiscard]] GaussianSet read_spz(const std::filesystem::path& file);
/// The same of its bytes; `file` is for messages.
[[nodiscard]] GaussianSet read_spz(std::string bytes, const std::string& file, SplatReport* report = nullptr);
/// Version 3, of a set with y down. What its numbers can't hold is clipped: colours to -0.4 to 1.4, SH to -1
/// to 1, scales to 45 um to 380 m. Error{kInput} for what validate() refuses, for LiDAR sets, and for means
/// so far out that fewer than 4 fractional bits would be left (half a million metres).
void write_spz(const std::filesystem::path& file, const GaussianSet& set);

/// glTF 2.0 in one binary file: the particles of all primitives with KHR_gaussian_splatting (kernel
/// "ellipse", colour space "srgb_rec709_display") of its default scene, where the nodes put them; floats and
/// the normalised integers that it allows, and the draft KHR_gaussian_splatting_compression_spz_2, whose
/// numbers are taken to be in glTF's axes, as CesiumJS takes them. Error{kInput} naming file and field for
/// other kernels and colour spaces, files beside this one, sparse accessors, nodes that are sheared or scaled
/// unevenly, and whatever else does not hold what it should.
[[nodiscard]] GaussianSet read_glb(const std::string& bytes,
                                   const std::string& file,
                                   SplatReport* report = nullptr);
/// The bytes of such a file: one primitive, floats, COLOR_0 for viewers that know no splats; compress: SPZ 3.
/// Error{kInput} for what validate() refuses, LiDAR sets, and more than 4 GiB.
[[nodiscard]] std::string glb_of(const GaussianSet& set, const SplatOutput& how, const std::string& file);

/// A .usdz is a StoredZip whose first file is its layer.
inline constexpr std::size_t kUsdzAlignment = 64;
inline constexpr char kUsdzLayer[] = "splats.usda";
/// An OpenUSD layer (.usda): one ParticleField3DGaussianSplat "Splats", metres, z up for a set with z up,
/// else y up. Errors as glb_of().
[[nodiscard]] std::string usda_of(const GaussianSet& set, SplatAxes axes, const std::string& file);

}  // namespace simuli
