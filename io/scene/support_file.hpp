#pragma once
// What a scene folder keeps of the frames that it was made of (host/core/record/support_record.hpp):
// scene.json has the sensors' grids, the views and the actors' tracks as recorded, support.exr the cells of
// all views one behind the other, four numbers each, in rows of kSupportRow numbers:
//   "support": {"sensors": [{"sensor", "set", "columns", "rows", "first_column", "columns_per_unit",
//   "first_row",
//     "rows_per_unit", "rays_per_rad"}, ...], "views": [{"sensor": place in sensors, "time_s",
//     "world_from_view"}, ...], "actors": as the scene's}
#include <filesystem>
#include <memory>
#include <string>

#include "host/core/record/support_record.hpp"
#include "io/log/log_json.hpp"

namespace simuli {

inline constexpr int kSupportRow = 4096;

[[nodiscard]] bool is_support_file(const std::string& name);
/// Adds it to scene.json; nothing of null.
void add_support(Json& root, const SupportRecord* record);
/// What scene.json says of it, without cells; null when it doesn't.
[[nodiscard]] std::shared_ptr<SupportRecord> read_support(JsonObject& root);
/// Writes the cells, atomically; nothing of null. Error{kInput} for a record that validate() refuses.
void write_support_cells(const std::filesystem::path& folder, const SupportRecord* record);
/// Reads the cells into what read_support() left. Error{kInput} when the file is not as scene.json says.
void read_support_cells(const std::filesystem::path& folder, SupportRecord& record);

}  // namespace simuli
