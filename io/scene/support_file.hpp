#pragma once
// The support record of a scene folder (host/core/record/support_record.hpp): scene.json contains the sensors'
// grids, the views and the actors' recorded tracks, support.exr the cells of all views in sequence, four numbers
// each, in rows of kSupportRow numbers:
//   "support": {"sensors": [{"sensor", "set", "columns", "rows", "first_column", "columns_per_unit",
//   "first_row",
//     "rows_per_unit", "rays_per_rad"}, ...], "views": [{"sensor": index in sensors, "time_s",
//     "world_from_view"}, ...], "actors": as the scene's}
#include <filesystem>
#include <memory>
#include <string>

#include "host/core/record/support_record.hpp"
#include "io/log/log_json.hpp"

namespace simuli {

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

}  // namespace simuli
