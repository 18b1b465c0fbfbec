#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/picture/sized_image.hpp"
#include "io/scene/scene_parts.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCellsName = "support.exr";
constexpr std::size_t kNumbers = 4;  // per cell
constexpr std::int64_t kMostColumns = 4096;

Json support_sensor_json(const SupportSensor& sensor) {
  const SupportGrid& grid = sensor.grid;
  return {{"sensor", sensor.name},
          {"set", sensor.kind == SetKind::kCamera ? "camera" : "lidar"},
          {"columns", grid.columns},
          {"rows", grid.rows},
          {"first_column", grid.first_column},
          {"columns_per_unit", grid.columns_per_unit},
          {"first_row", grid.first_row},
          {"rows_per_unit", grid.rows_per_unit},
          {"rays_per_rad", grid.rays_per_rad}};
}

SupportSensor support_sensor_from_json(JsonObject& object) {
  SupportSensor sensor;
  sensor.name = object.text("sensor");
  const std::string set = object.text("set");
  if (set != "camera" && set != "lidar") {
    throw_input_error(object.file(), object.field("set"), '"' + set + '"', "\"camera\" or \"lidar\"");
  }
  sensor.kind = set == "camera" ? SetKind::kCamera : SetKind::kLidar;
  SupportGrid& grid = sensor.grid;
  grid.columns = static_cast<int>(object.integer("columns", 1, kMostColumns));
  grid.rows = static_cast<int>(object.integer("rows", 1, kMostColumns));
  grid.first_column = object.number("first_column");
  grid.columns_per_unit = object.number("columns_per_unit", 0.0);
  grid.first_row = object.number("first_row");
  grid.rows_per_unit = object.number("rows_per_unit", 0.0);
  grid.rays_per_rad = object.number("rays_per_rad", 0.0);
  return sensor;
}

/// Returns the rows of the picture for that number of cells.
int height_of(std::size_t cells) {
  const std::size_t row = static_cast<std::size_t>(kSupportRow) / kNumbers;
  return static_cast<int>(std::max<std::size_t>(1, (cells + row - 1) / row));
}

std::size_t cells_of(const SupportRecord& record) {
  std::size_t cells = 0;
  for (const SupportView& view : record.views) cells += record.sensors[view.sensor].grid.cells();
  return cells;
}

}  // namespace

bool is_support_file(const std::string& name) { return name == kCellsName; }

void add_support(Json& root, const SupportRecord* record) {
  if (record == nullptr) return;
  Json sensors = Json::array(), views = Json::array();
  for (const SupportSensor& sensor : record->sensors) sensors.push_back(support_sensor_json(sensor));
  for (const SupportView& view : record->views) {
    views.push_back({{"sensor", view.sensor},
                     {"time_s", view.time_s},
                     {"world_from_view", simuli::to_json(view.world_from_view)}});
  }
  root["support"] = {{"sensors", std::move(sensors)}, {"views", std::move(views)}};
  if (!record->actors.empty()) root["support"]["actors"] = simuli::to_json(record->actors, 0);
}

std::shared_ptr<SupportRecord> read_support(JsonObject& root) {
  if (!root.has("support")) return nullptr;
  auto record = std::make_shared<SupportRecord>();
  root.object("support", [&](JsonObject& object) {
    record->sensors = object.objects("sensors", support_sensor_from_json);
    const auto last = static_cast<std::int64_t>(record->sensors.size()) - 1;
    record->views = object.objects("views", [&](JsonObject& view) {
      SupportView out;
      out.sensor = static_cast<std::size_t>(view.integer("sensor", 0, last));
      out.time_s = view.number("time_s");
      out.world_from_view = view.object("world_from_view", pose_from_json);
      return out;
    });
    if (object.has("actors")) record->actors = actors_from_json(object, "actors", 0);
  });
  return record;
}

void write_support_cells(const fs::path& folder, const SupportRecord* record) {
  if (record == nullptr) return;
  const fs::path file = folder / kCellsName;
  validate(*record, file.string());
  Image image(kSupportRow, height_of(record->cells.size()), 1);
  std::size_t at = 0;
  for (const SupportCell& c : record->cells) {
    for (const float value : {c.nearest_m, c.farthest_m, c.log_error, c.log_contrast})
      image.data[at++] = value;
  }
  write_image(file, image);
}

void read_support_cells(const fs::path& folder, SupportRecord& record) {
  const fs::path file = inside(folder, kCellsName, folder.string(), "file");
  const std::size_t cells = cells_of(record);
  const Image image = read_image(file, kSupportRow, height_of(cells), "scene.json");
  const auto channels = static_cast<std::size_t>(image.channels);
  const auto value = [&](std::size_t i) { return image.data[i * channels]; };
  record.cells.resize(cells);
  for (std::size_t i = 0; i < cells; ++i) {
    record.cells[i] = {
        value(kNumbers * i), value(kNumbers * i + 1), value(kNumbers * i + 2), value(kNumbers * i + 3)};
  }
  validate(record, file.string());
}

}  // namespace simuli
