#include "io/base/fields_json.hpp"

#include "host/base/error.hpp"

namespace simuli {
namespace {

Json json_of(const EnumValue& /*unused*/, const Field& field) { return field.text(); }
template <class T>
Json json_of(const T* value, const Field& /*unused*/) {
  return *value;
}

Json json_of(const Field& field) {
  return std::visit([&](const auto& value) { return json_of(value, field); }, field.value);
}

}  // namespace

Json json_of(const Fields& fields) {
  Json object = Json::object();
  for (const Field& field : fields.all()) object[field.key] = json_of(field);
  return object;
}

Json help_json(const Fields& fields) {
  Json rows = Json::array();
  for (const Field& field : fields.all()) {
    rows.push_back(
        {{"key", field.key}, {"default", json_of(field)}, {"allowed", field.allowed()}, {"help", field.help}});
  }
  return rows;
}

void read_fields(JsonObject& object, const Fields& fields) {
  for (const Field& field : fields.all()) {
    if (!object.has(field.key)) continue;
    const Json& value = object.get(field.key);
    const bool is_named = std::holds_alternative<EnumValue>(field.value);
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    if (value.is_string() == is_named && field.set(text)) continue;
    throw_input_error(object.file(), object.field(field.key), value.dump(), field.allowed());
  }
}

}  // namespace simuli
