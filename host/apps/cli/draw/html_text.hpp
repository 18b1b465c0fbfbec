#pragma once
// Text and bytes as they stand in HTML.
#include <string>
#include <string_view>

namespace simuli {

/// Plain text, between tags or in an attribute.
[[nodiscard]] std::string escaped_html(std::string_view text);
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace simuli
