#include <limits>
#include <string>
#include <variant>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli {
namespace {

constexpr char kRows[] = "lidar";
constexpr char kList[] = "ray_list";

const char* to_string(SpinDirection spin) {
  return spin == SpinDirection::kClockwise ? "clockwise" : "counter_clockwise";
}

SpinDirection read_spin(JsonObject& object) {
  const std::string name = object.text("spin");
  for (const SpinDirection spin : {SpinDirection::kClockwise, SpinDirection::kCounterClockwise}) {
    if (name == to_string(spin)) return spin;
  }
  throw_input_error(
      object.file(), object.field("spin"), Json(name).dump(-1, ' ', true), "clockwise or counter_clockwise");
}

Json ray_list_json(const RayList& list) {
  Json json{{"kind", kList},
            {"name", list.name},
            {"range_min_m", list.range_min},
            {"range_max_m", list.range_max},
            {"beam_divergence_rad", list.beam_divergence},
            {"divergence_variance", list.divergence_variance},
            {"azimuth_rad", list.azimuth},
            {"elevation_rad", list.elevation},
            {"time_fraction", list.time_fraction}};
  if (list.sweep_s != kUsualSweep_s) json["sweep_s"] = list.sweep_s;
  if (!list.origin.empty()) {
    Json origins = Json::array();
    for (const Eigen::Vector3d& origin : list.origin) {
      for (const double value : origin) origins.push_back(value);
    }
    json["origin_m"] = std::move(origins);
  }
  return json;
}

RayList ray_list_from_json(JsonObject& object) {
  RayList list;
  list.name = object.text("name");
  need_name(list.name, object.file(), object.field("name"));
  if (object.has("sweep_s")) list.sweep_s = object.number("sweep_s");
  list.range_min = object.number("range_min_m");
  list.range_max = object.number("range_max_m");
  list.beam_divergence = object.number("beam_divergence_rad");
  list.divergence_variance = object.number("divergence_variance");
  list.azimuth = object.numbers("azimuth_rad");
  list.elevation = object.numbers("elevation_rad");
  list.time_fraction = object.numbers("time_fraction");
  if (object.has("origin_m")) {
    const std::vector<double> values = object.numbers("origin_m");
    if (values.size() != 3 * list.ray_count()) {
      throw_input_error(object.file(),
                        object.field("origin_m"),
                        std::to_string(values.size()) + " numbers",
                        "three per ray, or no such key");
    }
    for (std::size_t i = 0; i < values.size(); i += 3) {
      list.origin.emplace_back(values[i], values[i + 1], values[i + 2]);
    }
  }
  validate(list, object.file());
  return list;
}

Json row_model_json(const Lidar& model) {
  Json rows = Json::array();
  for (const LidarRow& row : model.rows) {
    rows.push_back({{"elevation_rad", row.elevation},
                    {"azimuth_offset_rad", row.azimuth_offset},
                    {"vertical_offset_m", row.vertical_offset},
                    {"horizontal_offset_m", row.horizontal_offset},
                    {"time_offset_s", row.time_offset},
                    {"radial_offset_m", row.radial_offset}});
    if (row.range_bias != 0.0) rows.back()["range_bias_m"] = row.range_bias;
    if (row.every != 1) {
      rows.back()["fires_every"] = row.every;
      rows.back()["fires_first"] = row.first;
    }
  }
  Json json{{"kind", kRows},
            {"name", model.name},
            {"columns", model.columns},
            {"azimuth_first_rad", model.azimuth_first},
            {"azimuth_span_rad", model.azimuth_span},
            {"spin", to_string(model.spin)},
            {"range_min_m", model.range_min},
            {"range_max_m", model.range_max},
            {"beam_divergence_rad", model.beam_divergence},
            {"divergence_variance", model.divergence_variance},
            {"rows", rows}};
  if (model.sweep_s != kUsualSweep_s) json["sweep_s"] = model.sweep_s;
  if (model.blind.empty()) return json;
  Json& arcs = json["blind_arcs"] = Json::array();
  for (const BlindArc& arc : model.blind) {
    arcs.push_back(
        {{"row", arc.row}, {"azimuth_first_rad", arc.azimuth_first}, {"azimuth_last_rad", arc.azimuth_last}});
    if (arc.own_returns) arcs.back()["own_returns"] = true;
  }
  return json;
}

Lidar row_model_from_json(JsonObject& object) {
  Lidar model;
  model.name = object.text("name");
  need_name(model.name, object.file(), object.field("name"));
  model.columns = static_cast<int>(object.integer("columns", 1, kMostColumns));
  if (object.has("sweep_s")) model.sweep_s = object.number("sweep_s");
  model.azimuth_first = object.number("azimuth_first_rad");
  model.azimuth_span = object.number("azimuth_span_rad");
  model.spin = read_spin(object);
  model.range_min = object.number("range_min_m");
  model.range_max = object.number("range_max_m");
  model.beam_divergence = object.number("beam_divergence_rad");
  model.divergence_variance = object.number("divergence_variance");
  model.rows = object.objects("rows", [](JsonObject& row) {
    return LidarRow{
        row.number("elevation_rad"),
        row.number("azimuth_offset_rad"),
        row.number("vertical_offset_m"),
        row.number("horizontal_offset_m"),
        row.number("time_offset_s"),
        row.has("radial_offset_m") ? row.number("radial_offset_m") : 0.0,
        row.has("range_bias_m") ? row.number("range_bias_m") : 0.0,
        row.has("fires_every") ? static_cast<int>(row.integer("fires_every", 1, kMostColumns)) : 1,
        row.has("fires_first") ? static_cast<int>(row.integer("fires_first", 0, kMostColumns)) : 0};
  });
  if (object.has("blind_arcs")) {
    model.blind = object.objects("blind_arcs", [](JsonObject& arc) {
      return BlindArc{static_cast<int>(arc.integer("row", 0, std::numeric_limits<int>::max())),
                      arc.number("azimuth_first_rad"),
                      arc.number("azimuth_last_rad"),
                      arc.has("own_returns") && arc.boolean("own_returns")};
    });
  }
  validate(model, object.file());
  return model;
}

}  // namespace

Json to_json(const LidarModel& model) {
  const auto* const list = std::get_if<RayList>(&model);
  return list == nullptr ? row_model_json(std::get<Lidar>(model)) : ray_list_json(*list);
}

LidarModel lidar_model_from_json(JsonObject& object) {
  const std::string kind = object.has("kind") ? object.text("kind") : kRows;
  if (kind == kRows) return row_model_from_json(object);
  if (kind == kList) return ray_list_from_json(object);
  throw_input_error(object.file(), object.field("kind"), Json(kind).dump(-1, ' ', true), "lidar or ray_list");
}

}  // namespace simuli
