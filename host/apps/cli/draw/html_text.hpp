#pragma once
// Encodes text and bytes for HTML.
#include <string>
#include <string_view>

namespace simuli {

/// Escapes plain text for element content and attributes.
[[nodiscard]] std::string escaped_html(std::string_view text);
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace simuli
