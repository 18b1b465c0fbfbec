#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "host/core/base/point_cloud.hpp"
#include "host/core/scene/gaussians.hpp"

namespace simuli {

/// Reads a set of Gaussians from a PLY: SuperSplat's compressed one (io/splat/splat_file.hpp), or the standard
/// 3DGS layout (x y z, f_dc_*, f_rest_* channel-major, opacity logit, scale_* log, rot_* w x y z); ascii or
/// binary of either endianness, properties by name in any order and of any scalar type; normals, unknown
/// properties and other elements are ignored; the SH degree follows from the number of f_rest. A property
/// "filter_3D" (Mip-Splatting's, a length) widens and dims each particle. A LiDAR set uses the same names; a
/// comment "simuli channels ..." of the other kind is refused. An integer property "actor" is
/// GaussianSet::actor. Throws Error{kInput} (file, property, vertex, found, allowed) for counts that exceed the
/// file's size (checked before allocation), data after the end, NaN or Inf, zero quaternions, list properties,
/// missing properties, and the 2 scales of 2D Gaussians.
[[nodiscard]] GaussianSet read_gaussians_ply(const std::filesystem::path& file, SetKind kind);
/// The same for the bytes of a file; `file` appears in messages.
[[nodiscard]] GaussianSet read_gaussians_ply(const std::string& bytes, SetKind kind, const std::string& file);
/// The same without validate(): values may be NaN or Inf, quaternions zero.
[[nodiscard]] GaussianSet parse_gaussians_ply(const std::string& bytes,
                                              SetKind kind,
                                              const std::string& file);
/// Writes binary little endian in the standard 3DGS property order (x y z nx ny nz f_dc f_rest opacity scale
/// rot) with a comment that names the channels; sets with actors add the property uint "actor". Throws the
/// errors of validate().
void write_gaussians_ply(const std::filesystem::path& file, const GaussianSet& set);
/// Throws Error{kInput} naming `file`, vertex and property for an invalid set: columns that contradict the SH
/// degree, a wrong number of actors, NaN or Inf, a zero quaternion.
void validate(const GaussianSet& set, const std::string& file);
/// Removes the particles that validate() refuses; returns their number.
Eigen::Index leave_out_broken(GaussianSet& set);

/// Returns the vertices of a PLY in m: its properties x, y, z; formats, types and errors as in
/// read_gaussians_ply().
[[nodiscard]] std::vector<Eigen::Vector3d> read_points_ply(const std::filesystem::path& file);
/// Throws Error{kInput} naming `file` for columns without x, y, z, repeated names or names with blanks, a wrong
/// number of types, and values outside a column's type: NaN or Inf; for kUint16 all but 0 to 65535.
void validate(const PointCloud& cloud, const std::string& file);
/// Writes binary little endian; for other formats see io/splat/cloud_file.hpp. Throws the errors of validate().
void write_point_cloud_ply(const std::filesystem::path& file, const PointCloud& cloud);

}  // namespace simuli
