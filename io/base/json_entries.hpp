#pragma once
#include <functional>
#include <string>

#include "io/base/json_reader.hpp"

namespace simuli {

/// Reads a file whose root is an array of objects, each forgotten before the next one: tables are large.
/// Errors as of read_json_text(), one of an entry before one of what stands behind it.
void read_json_entries(const std::string& text,
                       const std::string& file,
                       const std::function<void(JsonObject&)>& read);

}  // namespace simuli
