#include <cstdint>
#include <limits>
#include <type_traits>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/core/base/one_line.hpp"
#include "io/scene/scene_parts.hpp"

namespace simuli {
namespace {

/// Reads a seed: any 64-bit integer.
std::uint64_t read_seed(JsonObject& object, const std::string& key) {
  const Json& seed = object.get(key);
  if (!seed.is_number_unsigned()) {
    throw_input_error(object.file(), object.field(key), seed.dump(), "an integer, 0 or more");
  }
  return seed.get<std::uint64_t>();
}

std::vector<std::string> read_lines(JsonObject& object, const std::string& key) {
  std::vector<std::string> lines;
  const Json& array = object.get(key);
  const auto refuse = [&] {
    throw_input_error(object.file(), object.field(key), "something else", "an array of strings");
  };
  if (!array.is_array()) refuse();
  for (const Json& line : array) {
    if (!line.is_string()) refuse();
    lines.push_back(on_one_line(line.get<std::string>()));
  }
  return lines;
}

HeldOutScores read_scores(JsonObject& object) {
  HeldOutScores scores;
  visit_scores(scores, [&object](const char* key, auto& value) {
    using Value = std::remove_reference_t<decltype(value)>;
    if constexpr (std::is_integral_v<Value>) {
      value = static_cast<Value>(object.integer(key, 0, std::numeric_limits<int>::max()));
    } else {  // null without such frames
      value = object.get(key).is_null() ? std::numeric_limits<double>::quiet_NaN() : object.number(key);
    }
  });
  return scores;
}

}  // namespace

Json to_json(const HeldOutScores& scores) {
  Json out = Json::object();
  visit_scores(scores, [&out](const char* key, const auto& value) { out[key] = value; });
  return out;
}

Json to_json(const TrainingRecord& r) {
  Json sensors = Json::array();
  for (const SensorUse& use : r.sensors) {
    sensors.push_back({{"sensor", use.sensor}, {"training", use.training}, {"held_out", use.held_out}});
  }
  return {{"log", {{"name", r.log_name}, {"hash", r.log_hash}}},
          {"image_scale", r.frames.image_scale},
          {"held_out_every", r.frames.held_out_every},
          {"held_out_middle", r.frames.held_out_middle},
          {"held_out_last", r.frames.held_out_last},
          {"held_out_sensors", r.frames.held_out_sensors},
          {"held_out_by_sensor", r.frames.counts_by_sensor},
          {"sensors", sensors},
          {"labels_left_out", r.labels_left_out},
          {"seed", r.frames.seed},
          {"iterations", r.iterations},
          {"planned_iterations", r.planned_iterations},
          {"quality", r.quality},
          {"settings", r.settings},
          {"simuli", r.version},
          {"device", r.device},
          {"driver", r.driver},
          {"held_out", r.held_out ? to_json(*r.held_out) : Json()}};
}

TrainingRecord training_from_json(JsonObject& object) {
  constexpr int kMost = std::numeric_limits<int>::max();
  TrainingRecord r;
  object.object("log", [&r](JsonObject& log) {
    r.log_name = log.text("name");
    r.log_hash = log.text("hash");
  });
  r.frames.image_scale = object.number("image_scale", 0.0, 1.0);
  r.frames.held_out_every = static_cast<int>(object.integer("held_out_every", 0, kMost));
  // Scenes of older versions lack these rules.
  if (object.has("held_out_middle")) r.frames.held_out_middle = object.number("held_out_middle", 0.0, 1.0);
  if (object.has("held_out_last")) r.frames.held_out_last = object.number("held_out_last", 0.0, 1.0);
  if (object.has("held_out_sensors")) r.frames.held_out_sensors = read_lines(object, "held_out_sensors");
  // Older versions held out every N-th of all cameras' pictures together, and of all LiDARs' sweeps.
  r.frames.counts_by_sensor = object.has("held_out_by_sensor") && object.boolean("held_out_by_sensor");
  if (object.has("sensors")) {
    r.sensors = object.objects("sensors", [](JsonObject& sensor) {
      const auto count = [&](const char* key) {
        return static_cast<std::size_t>(sensor.integer(key, 0, std::numeric_limits<int>::max()));
      };
      return SensorUse{sensor.text("sensor"), count("training"), count("held_out")};
    });
  }
  if (object.has("labels_left_out")) r.labels_left_out = read_lines(object, "labels_left_out");
  r.frames.seed = read_seed(object, "seed");
  r.iterations = static_cast<int>(object.integer("iterations", 0, kMost));
  r.planned_iterations = static_cast<int>(object.integer("planned_iterations", 0, kMost));
  r.quality = object.text("quality");
  r.settings = read_lines(object, "settings");
  r.version = object.text("simuli");
  r.device = object.text("device");
  r.driver = object.text("driver");
  // Scenes of older versions lack them.
  if (object.has("held_out") && !object.get("held_out").is_null()) {
    r.held_out = object.object("held_out", read_scores);
  }
  const Fields fields = fields_of(r.frames);
  for (const Field& field : fields.all()) {
    if (field.is_sound()) continue;
    throw_input_error(object.file(), object.field(field.key), field.text(), field.allowed());
  }
  return r;
}

}  // namespace simuli
