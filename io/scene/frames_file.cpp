#include "io/scene/frames_file.hpp"

#include <variant>

#include "io/base/file.hpp"
#include "io/log/log_json.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli {

void write_frames_file(const std::filesystem::path& file, const FramesRecord& record) {
  Json frames = Json::array();
  for (const FrameRecord& frame : record.frames) {
    frames.push_back({{"files", frame.files},
                      {"time_start_s", frame.time_start_s},
                      {"time_end_s", frame.time_end_s},
                      {"world_from_sensor_start", to_json(frame.world_from_sensor_start)},
                      {"world_from_sensor_end", to_json(frame.world_from_sensor_end)}});
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
    root["actors"].push_back({{"id", actor.id}, {"name", actor.name}, {"kind", actor.kind}});
  }
  root["frames"] = std::move(frames);
  // A path on the command line need not be UTF-8: what is not stands as U+FFFD.
  write_file_atomically(file, root.dump(1, ' ', false, Json::error_handler_t::replace) + '\n');
}

}  // namespace simuli
