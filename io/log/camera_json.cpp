#include <string>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/image.hpp"
#include "host/core/base/names.hpp"
#include "io/log/sensor_json.hpp"

namespace simuli {
namespace {

constexpr const char* kForward = "forward";
constexpr const char* kBackward = "backward";

Json to_json(const Windshield& glass) {
  return {{"reference", glass.reference == Windshield::Reference::kForward ? kForward : kBackward},
          {"horizontal", glass.horizontal},
          {"vertical", glass.vertical},
          {"horizontal_inverse", glass.horizontal_inverse},
          {"vertical_inverse", glass.vertical_inverse}};
}

Windshield windshield_from_json(JsonObject& object) {
  const std::string reference = object.text("reference");
  if (reference != kForward && reference != kBackward) {
    throw_input_error(
        object.file(), object.field("reference"), '"' + reference.substr(0, 60) + '"', "forward or backward");
  }
  Windshield glass;
  glass.reference =
      reference == kForward ? Windshield::Reference::kForward : Windshield::Reference::kBackward;
  glass.horizontal = object.numbers("horizontal");
  glass.vertical = object.numbers("vertical");
  glass.horizontal_inverse = object.numbers("horizontal_inverse");
  glass.vertical_inverse = object.numbers("vertical_inverse");
  return glass;
}

}  // namespace

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
  if (model.lens.windshield()) json["windshield"] = to_json(*model.lens.windshield());
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
  const std::string field = object.field("model");  // "cameras[0].model", or "model" of a file's root
  const std::size_t dot = field.rfind('.');
  const std::string where = object.file() + (dot == std::string::npos ? "" : ": " + field.substr(0, dot));
  if (object.has("model")) {
    const LensKind kind = lens_from_string(object.text("model"), object.file(), object.field("model"));
    std::vector<double> parameters;
    for (const std::string& name : lens_parameter_names(kind)) parameters.push_back(object.number(name));
    model.lens = Lens(kind, parameters, where);
  }
  if (object.has("windshield")) {
    model.lens = model.lens.behind(object.object("windshield", windshield_from_json), where);
  }
  model.shutter = shutter_from_string(object.text("shutter"), object.file(), object.field("shutter"));
  validate(model, object.file());
  return model;
}

}  // namespace simuli
