#pragma once
// Makes untrusted text safe for display.
#include <cstddef>
#include <string>
#include <string_view>

namespace simuli {

/// Returns the bytes of a character at `at` that affects the display of its surroundings; 0 for others. These
/// are control characters, including U+0080 to U+009F; characters that change text direction, with which text
/// can read differently (U+200E, U+200F, U+2028 to U+202E, U+2066 to U+2069); and the invisible byte order mark
/// U+FEFF. 1 for an invalid UTF-8 byte.
[[nodiscard]] std::size_t unprintable(std::string_view text, std::size_t at);

/// Returns `text` with the bytes of such characters as \xHH.
[[nodiscard]] std::string on_one_line(std::string_view text);

}  // namespace simuli
