#pragma once
// Options as JSON, by their keys.
#include "host/base/fields.hpp"
#include "io/base/json_reader.hpp"

namespace simuli {

/// {"KEY": value, ...}.
[[nodiscard]] Json json_of(const Fields& fields);
/// What Fields::help() tells, as [{"key", "default", "allowed", "help"}...].
[[nodiscard]] Json help_json(const Fields& fields);
/// Sets fields from what json_of() made; those without a key in it stay as they are. Error{kInput} naming
/// file and key for a value that is not allowed.
void read_fields(JsonObject& object, const Fields& fields);

}  // namespace simuli
