#include "io/log/sensor_file.hpp"

#include <fmt/format.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli {
namespace {

constexpr char kCamera[] = "camera";
constexpr char kLidars[] = "lidar or ray_list";
constexpr std::size_t kMostBytes = std::size_t{2} << 30U;  // 2^24 rays of six numbers with 17 digits

std::string text_or_none(JsonObject& object, const char* key) {
  return object.has(key) ? object.text(key) : std::string();
}

void add_texts(Json& json, const std::string& source, const std::string& licence, const std::string& note) {
  if (!source.empty()) json["source"] = source;
  if (!licence.empty()) json["licence"] = licence;
  if (!note.empty()) json["note"] = note;
}

/// Refuses a read-out time for a global shutter.
void check_readout(const CameraFile& file, const std::string& where, const std::string& field) {
  if (file.readout_s == 0.0 || file.model.shutter != ShutterKind::kGlobal) return;
  throw_input_error(
      where, field, fmt::format("{} with a global shutter", file.readout_s), "0, or no such key");
}

CameraFile camera_file_from_json(JsonObject& object) {
  CameraFile file;
  file.source = text_or_none(object, "source");
  file.licence = text_or_none(object, "licence");
  file.note = text_or_none(object, "note");
  if (object.has("readout_s")) file.readout_s = object.number("readout_s", 0.0);
  file.model = camera_model_from_json(object);
  check_readout(file, object.file(), object.field("readout_s"));
  return file;
}

LidarFacts facts_from_json(JsonObject& object) {
  LidarFacts facts;
  facts.source = text_or_none(object, "source");
  facts.licence = text_or_none(object, "licence");
  facts.note = text_or_none(object, "note");
  if (object.has("modes")) {
    facts.modes = object.objects("modes", [](JsonObject& mode) {
      return LidarMode{mode.number("spin_hz", 1e-3, 1e4),
                       static_cast<int>(mode.integer("columns", 1, kMostColumns))};
    });
    if (!facts.modes.empty()) facts.mode = facts.modes.front();
  }
  return facts;
}

void add_facts(Json& json, const LidarFacts& facts) {
  add_texts(json, facts.source, facts.licence, facts.note);
  if (facts.modes.empty()) return;
  Json modes = Json::array();
  const auto add = [&modes](const LidarMode& mode) {
    modes.push_back({{"spin_hz", mode.spin_hz}, {"columns", mode.columns}});
  };
  add(facts.mode);
  for (const LidarMode& mode : facts.modes) {
    if (mode.spin_hz != facts.mode.spin_hz || mode.columns != facts.mode.columns) add(mode);
  }
  json["modes"] = std::move(modes);
}

LidarFile lidar_file_from_json(JsonObject& object) {
  LidarFile file;
  file.facts = facts_from_json(object);
  const bool has_sweep = object.has("sweep_s");
  file.model = lidar_model_from_json(object);
  if (!has_sweep && !file.facts.modes.empty()) {
    std::visit([&](auto& model) { model.sweep_s = 1.0 / file.facts.mode.spin_hz; }, file.model);
  }
  const auto* const lidar = std::get_if<Lidar>(&file.model);
  if (lidar != nullptr && !file.facts.modes.empty() && file.facts.mode.columns != lidar->columns) {
    throw_input_error(object.file(),
                      object.field("modes[0].columns"),
                      std::to_string(file.facts.mode.columns),
                      std::to_string(lidar->columns) + ", the model's");
  }
  return file;
}

/// Reads a sensor file that must contain a sensor of that kind.
template <class File>
File read_kind(const std::filesystem::path& path, const char* found, const char* allowed) {
  SensorFile file = read_sensor_file(path);
  if (auto* const wanted = std::get_if<File>(&file)) return std::move(*wanted);
  throw_input_error(path.string(), "kind", found, allowed);
}

void check(const CameraFile& file, const std::string& where) {
  validate(file.model, where);
  check_readout(file, where, "readout_s");
}
void check(const LidarFile& file, const std::string& where) { validate(file.model, where); }

}  // namespace

SensorFile sensor_file_from_json(JsonObject& object) {
  const std::string kind = object.text("kind");  // required in sensor files
  if (kind == kCamera) return camera_file_from_json(object);
  if (kind == "lidar" || kind == "ray_list") return lidar_file_from_json(object);
  throw_input_error(object.file(),
                    object.field("kind"),
                    Json(kind).dump(-1, ' ', true),
                    fmt::format("{}, {}", kCamera, kLidars));
}

SensorFile read_sensor_file(const std::filesystem::path& file) {
  return read_json_text(read_file(file, kMostBytes), file.string(), sensor_file_from_json);
}

CameraFile read_camera_file(const std::filesystem::path& file) {
  return read_kind<CameraFile>(file, "a LiDAR", kCamera);
}

LidarFile read_lidar_file(const std::filesystem::path& file) {
  return read_kind<LidarFile>(file, "a camera", kLidars);
}

void write_sensor_file(const std::filesystem::path& path, const SensorFile& file) {
  std::visit([&](const auto& sensor) { check(sensor, path.string()); }, file);
  write_file_atomically(path, text_of(file));
}

SensorFile sensor_file_from_text(const std::string& text, const std::string& where) {
  return read_json_text(text, where, sensor_file_from_json);
}

std::string text_of(const SensorFile& file) {
  return std::visit([](const auto& sensor) { return to_json(sensor); }, file).dump(2) + '\n';
}

Sensor sensor_of(const SensorFile& file) {
  if (const auto* const camera = std::get_if<CameraFile>(&file)) {
    return Sensor(camera->model, {}, camera->readout_s);
  }
  return Sensor(std::get<LidarFile>(file).model);
}

SensorFile sensor_file_of(const Sensor& sensor) {
  if (!sensor.is_camera()) return LidarFile{sensor.lidar()};
  const bool rolls = sensor.camera().shutter != ShutterKind::kGlobal;
  return CameraFile{sensor.camera(), rolls ? sensor.duration_s() : 0.0};
}

Json to_json(const CameraFile& file) {
  const Json model = to_json(file.model);
  Json json{{"kind", kCamera}, {"name", model.at("name")}};
  add_texts(json, file.source, file.licence, file.note);
  json.update(model);
  if (file.readout_s != 0.0) json["readout_s"] = file.readout_s;
  return json;
}

Json to_json(const LidarFile& file) {
  const Json model = to_json(file.model);
  Json json{{"kind", model.at("kind")}, {"name", model.at("name")}};
  add_facts(json, file.facts);
  json.update(model);
  return json;
}

}  // namespace simuli
