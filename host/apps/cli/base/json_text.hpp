#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace simuli::cli {

/// Indented, as commands print it: in ASCII, for terminals; bytes of paths that are no UTF-8 as U+FFFD.
template <class Json>
[[nodiscard]] std::string json_text(const Json& json) {
  return json.dump(2, ' ', true, Json::error_handler_t::replace);
}

}  // namespace simuli::cli
