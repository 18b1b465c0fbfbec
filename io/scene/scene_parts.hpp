#pragma once
// Parts of a scene folder besides its particles: appearance, support record, training record.
#include <filesystem>
#include <memory>
#include <string>

#include "host/core/record/support_record.hpp"
#include "host/core/scene/scene.hpp"
#include "io/base/json_reader.hpp"
#include "io/log/log_json.hpp"
#include "io/scene/training_record.hpp"

namespace simuli {

// The appearance of a scene folder: environment.exr (equirectangular, centre along +x) and color_grids.exr.
//
// color_grids.exr contains the grids side by side in rows of up to 8. In a grid, the pixel at
// ((x size_z + z) 4 + column, y) has the three rows of one column of the transform at vertex (x, y, z).
// scene.json describes the pictures:
//   "environment": {"width_px", "height_px"}
//   "color_grids": {"size": [x, y, z], "frames": [{"camera", "time_s"}, ...]}

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

// The support record of a scene folder (host/core/record/support_record.hpp): scene.json contains the sensors'
// grids, the views and the actors' recorded tracks, support.exr the cells of all views in sequence, four numbers
// each, in rows of kSupportRow numbers:
//   "support": {"sensors": [{"sensor", "set", "columns", "rows", "first_column", "columns_per_unit",
//   "first_row",
//     "rows_per_unit", "rays_per_rad"}, ...], "views": [{"sensor": index in sensors, "time_s",
//     "world_from_view"}, ...], "actors": as the scene's}

inline constexpr int kSupportRow = 4096;

[[nodiscard]] bool is_support_file(const std::string& name);
/// Adds the record to scene.json; does nothing for null.
void add_support(Json& root, const SupportRecord* record);
/// Returns the record of scene.json without cells; null if there is none.
[[nodiscard]] std::shared_ptr<SupportRecord> read_support(JsonObject& root);
/// Writes the cells atomically; does nothing for null. Throws Error{kInput} for a record that validate()
/// refuses.
void write_support_cells(const std::filesystem::path& folder, const SupportRecord* record);
/// Reads the cells into the result of read_support(). Throws Error{kInput} if the file contradicts scene.json.
void read_support_cells(const std::filesystem::path& folder, SupportRecord& record);

/// Non-finite values become null.
[[nodiscard]] Json to_json(const HeldOutScores& scores);
[[nodiscard]] Json to_json(const TrainingRecord& record);
/// Errors as in io/base/json_reader.hpp.
[[nodiscard]] TrainingRecord training_from_json(JsonObject& object);

}  // namespace simuli
