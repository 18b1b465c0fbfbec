#include <string>
#include <vector>

#include "host/base/image.hpp"
#include "host/base/names.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli {

Json to_json(const Camera& model) {
  Json json = {{"name", model.name},
               {"model", simuli::to_string(model.lens.kind())},
               {"width_px", model.width},
               {"height_px", model.height},
               {"fx_px", model.fx},
               {"fy_px", model.fy},
               {"cx_px", model.cx},
               {"cy_px", model.cy}};
  const auto& names = lens_parameter_names(model.lens.kind());
  for (std::size_t i = 0; i < names.size(); ++i) json[names[i]] = model.lens.parameters()[i];
  json["shutter"] = simuli::to_string(model.shutter);
  return json;
}

Camera camera_model_from_json(JsonObject& object) {
  Camera model;
  model.name = object.text("name");
  need_name(model.name, object.file(), object.field("name"));
  model.width = static_cast<int>(object.integer("width_px", 1, kLargestSide_px));
  model.height = static_cast<int>(object.integer("height_px", 1, kLargestSide_px));
  model.fx = object.number("fx_px");
  model.fy = object.number("fy_px");
  model.cx = object.number("cx_px");
  model.cy = object.number("cy_px");
  if (object.has("model")) {
    const LensKind kind = lens_from_string(object.text("model"), object.file(), object.field("model"));
    std::vector<double> parameters;
    for (const std::string& name : lens_parameter_names(kind)) parameters.push_back(object.number(name));
    const std::string field = object.field("model");  // "cameras[0].model", or "model" of a file's root
    const std::size_t dot = field.rfind('.');
    const std::string where = dot == std::string::npos ? "" : ": " + field.substr(0, dot);
    model.lens = Lens(kind, parameters, object.file() + where);
  }
  model.shutter = shutter_from_string(object.text("shutter"), object.file(), object.field("shutter"));
  validate(model, object.file());
  return model;
}

}  // namespace simuli
