#include "io/scene/frames_file.hpp"

#include <variant>

#include "io/base/file.hpp"
#include "io/log/log_json.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli {
namespace {

Json to_json(const std::optional<PixelBox>& box) {
  return box ? Json{box->left, box->top, box->right, box->bottom} : Json();
}

Json to_json(const ActorLabel& label, bool is_camera) {
  Json out{{"actor", label.actor + 1},
           {"time_s", label.time_s},
           {"size_m", {label.size_m.x(), label.size_m.y(), label.size_m.z()}},
           {"world_from_actor", to_json(label.world_from_actor)},
           {"rig_from_actor", to_json(label.rig_from_actor)},
           {"sensor_from_actor", to_json(label.sensor_from_actor)},
           {is_camera ? "pixels" : "returns", label.rays},
           {"occlusion", label.occlusion ? Json(*label.occlusion) : Json()}};
  if (!is_camera) return out;
  out["projected_px"] = to_json(label.projected_px);
  out["visible_px"] = to_json(label.visible_px);
  out["truncation"] = label.truncation;
  return out;
}

}  // namespace

void write_frames_file(const std::filesystem::path& file, const FramesRecord& record) {
  Json frames = Json::array();
  for (const FrameRecord& frame : record.frames) {
    frames.push_back({{"files", frame.files},
                      {"time_start_s", frame.time_start_s},
                      {"time_end_s", frame.time_end_s},
                      {"world_from_sensor_start", to_json(frame.world_from_sensor_start)},
                      {"world_from_sensor_end", to_json(frame.world_from_sensor_end)}});
    if (!record.has_labels) continue;
    Json& labels = frames.back()["labels"] = Json::array();
    for (const ActorLabel& label : frame.labels) labels.push_back(to_json(label, record.sensor.is_camera()));
  }
  Json root{{"format", "simuli frames"},
            {"version", 1},
            {"scene", record.scene},
            {"trajectory", record.trajectory},
            {"sensor",
             std::visit([](const auto& sensor) { return to_json(sensor); }, sensor_file_of(record.sensor))},
            {"rig_from_sensor", to_json(record.sensor.rig_from_sensor())},
            {"edits", record.edits},
            {"quality", record.quality},
            {"settings", record.settings},
            {"simuli", record.version},
            {"device", record.device},
            {"driver", record.driver}};
  if (!record.clouds.frame.empty()) {
    root["clouds"] = {{"frame", record.clouds.frame}, {"coordinates", record.clouds.coordinates}};
  }
  if (!record.outputs.empty()) root["outputs"] = record.outputs;
  for (const ActorRecord& actor : record.actors) {
    root["actors"].push_back(
        {{"id", actor.id}, {"name", actor.name}, {"kind", actor.kind}, {"class", actor.class_id}});
  }
  root["frames"] = std::move(frames);
  // Paths from the command line may not be UTF-8; invalid bytes become U+FFFD.
  write_file_atomically(file, root.dump(1, ' ', false, Json::error_handler_t::replace) + '\n');
}

}  // namespace simuli
