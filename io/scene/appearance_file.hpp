#pragma once
// The appearance of a scene folder: environment.exr (equirectangular, centre along +x) and color_grids.exr.
//
// color_grids.exr holds the grids side by side in rows of up to 8. In a grid, the pixel at
// ((x size_z + z) 4 + column, y) has the three rows of one column of the transform at vertex (x, y, z).
// scene.json says what the pictures hold:
//   "environment": {"width_px", "height_px"}
//   "color_grids": {"size": [x, y, z], "frames": [{"camera", "time_s"}, ...]}
#include <filesystem>
#include <string>

#include "host/core/scene/scene.hpp"
#include "io/log/log_json.hpp"

namespace simuli {

/// Adds what `scene` has of both to scene.json.
void add_appearance(Json& root, const Scene& scene);
/// The sizes and frames that scene.json names, without texels and values.
void read_appearance(JsonObject& root, Scene& scene);
/// Whether a file of a scene folder is one of the pictures.
[[nodiscard]] bool is_appearance_file(const std::string& name);
/// Writes the pictures of what `scene` has, atomically. Error{kInput} for values that are not finite.
void write_appearance(const std::filesystem::path& folder, const Scene& scene);
/// Reads texels and values into what read_appearance left. Error{kInput} when a picture is not as scene.json
/// says, or holds what is no number.
void read_appearance_files(const std::filesystem::path& folder, Scene& scene);

}  // namespace simuli
