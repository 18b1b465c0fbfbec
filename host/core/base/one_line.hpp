#pragma once
// Text from anybody, as it is shown to people.
#include <cstddef>
#include <string>
#include <string_view>

namespace simuli {

/// How many bytes a character at `at` has that changes how what stands around it is shown; 0 for all others.
/// Control characters, those of U+0080 to U+009F too, and what turns the direction of text, with which it
/// reads as another: U+200E, U+200F, U+2028 to U+202E, U+2066 to U+2069; and the byte order mark, U+FEFF, which
/// nobody sees. 1 for a byte that is no UTF-8.
[[nodiscard]] std::size_t unprintable(std::string_view text, std::size_t at);

/// With each byte of such characters as \xHH.
[[nodiscard]] std::string on_one_line(std::string_view text);

}  // namespace simuli
