#pragma once
// Numbers within one option's value: "0:1:0.1", "1,2,3", "640x480".
#include <cstddef>
#include <string>
#include <vector>

namespace simuli::cli {

/// Error{kUsage}.
[[noreturn]] void refuse(const std::string& what, const std::string& found, const std::string& allowed);

/// `count` finite numbers parted by `separator`; refused as `option`'s otherwise.
[[nodiscard]] std::vector<double> parse_numbers(const char* option,
                                                const std::string& text,
                                                std::size_t count,
                                                char separator);

}  // namespace simuli::cli
