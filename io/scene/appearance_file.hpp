#pragma once
// The appearance of a scene folder: environment.exr (equirectangular, centre along +x) and color_grids.exr.
//
// color_grids.exr contains the grids side by side in rows of up to 8. In a grid, the pixel at
// ((x size_z + z) 4 + column, y) has the three rows of one column of the transform at vertex (x, y, z).
// scene.json describes the pictures:
//   "environment": {"width_px", "height_px"}
//   "color_grids": {"size": [x, y, z], "frames": [{"camera", "time_s"}, ...]}
#include <filesystem>
#include <string>

#include "host/core/scene/scene.hpp"
#include "io/log/log_json.hpp"

namespace simuli {

/// Adds the description of the scene's environment and colour grids to scene.json.
void add_appearance(Json& root, const Scene& scene);
/// Reads sizes and frames from scene.json, without texels and values.
void read_appearance(JsonObject& root, Scene& scene);
/// Whether a file of a scene folder is one of the pictures.
[[nodiscard]] bool is_appearance_file(const std::string& name);
/// Writes the existing pictures atomically. Throws Error{kInput} for non-finite values.
void write_appearance(const std::filesystem::path& folder, const Scene& scene);
/// Reads texels and values into the result of read_appearance(). Throws Error{kInput} for a picture that
/// contradicts scene.json or contains non-finite values.
void read_appearance_files(const std::filesystem::path& folder, Scene& scene);

}  // namespace simuli
