#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "host/core/base/point_cloud.hpp"
#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// Reads a set of Gaussians from a PLY: SuperSplat's compressed one (io/splat/splat_file.hpp), or the
/// standard 3DGS layout (x y z, f_dc_*, f_rest_* channel-major, opacity logit, scale_* log, rot_* w x y z),
/// ascii or binary either endian, properties by name in any order and of any scalar type, normals, unknown
/// properties and other elements ignored, SH degree from the count of f_rest. A property "filter_3D"
/// (Mip-Splatting's, a length) widens and dims each particle. A LiDAR set uses the same names; a comment
/// "simuli channels ..." that belongs to the other kind is refused. An integer
/// property "actor" is GaussianSet::actor. Error{kInput} (file, property, vertex, found, allowed) for counts
/// that the file's size can't hold (checked before anything is allocated), more than blanks behind it, NaN
/// or Inf, zero quaternions, list properties, missing properties, and the 2 scales of 2D Gaussians.
[[nodiscard]] GaussianSet read_gaussians_ply(const std::filesystem::path& file, SetKind kind);
/// The same of its bytes; `file` is for messages.
[[nodiscard]] GaussianSet read_gaussians_ply(const std::string& bytes, SetKind kind, const std::string& file);
/// The same without validate(): particles may be NaN, Inf, or turned by no quaternion.
[[nodiscard]] GaussianSet parse_gaussians_ply(const std::string& bytes,
                                              SetKind kind,
                                              const std::string& file);
/// Binary little endian, the standard 3DGS property order (x y z nx ny nz f_dc f_rest opacity scale rot) and
/// a comment that names the channels; sets with actors add the property uint "actor". What validate() refuses
/// is not written.
void write_gaussians_ply(const std::filesystem::path& file, const GaussianSet& set);
/// Throws Error{kInput} naming `file`, vertex and property for a set that no file may hold: columns that
/// don't fit the SH degree, actors that are not one per particle, NaN or Inf, a zero quaternion.
void validate(const GaussianSet& set, const std::string& file);
/// Takes the particles that validate() refuses out of a set; returns how many.
Eigen::Index leave_out_broken(GaussianSet& set);

/// Where the vertices of a PLY are, m: its properties x, y, z; formats, types and errors as
/// read_gaussians_ply().
[[nodiscard]] std::vector<Eigen::Vector3d> read_points_ply(const std::filesystem::path& file);
/// Error{kInput} naming `file` for columns without x, y, z, names that stand twice or hold blanks, types that
/// are not one per column, values that a column's type does not hold: NaN or Inf, of kUint16 all but 0 to
/// 65535.
void validate(const PointCloud& cloud, const std::string& file);
/// Binary little endian; other formats: io/splat/cloud_file.hpp. Error{kInput} for what validate() refuses.
void write_point_cloud_ply(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace simuli
