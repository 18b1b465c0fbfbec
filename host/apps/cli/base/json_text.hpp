#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace simuli::cli {

/// Returns indented ASCII JSON, the output format of commands; bytes that are not UTF-8 become U+FFFD.
template <class Json>
[[nodiscard]] std::string json_text(const Json& json) {
  return json.dump(2, ' ', true, Json::error_handler_t::replace);
}

}  // namespace simuli::cli
