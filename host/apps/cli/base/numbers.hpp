#pragma once
// Numbers within one option's value: "0:1:0.1", "1,2,3", "640x480".
#include <cstddef>
#include <string>
#include <vector>

namespace simuli::cli {

/// `count` finite numbers parted by `separator`; refused as `option`'s otherwise, which allows what `allowed`
/// says, or such numbers where it says nothing.
[[nodiscard]] std::vector<double> parse_numbers(const char* option,
                                                const std::string& text,
                                                std::size_t count,
                                                char separator,
                                                const std::string& allowed = "");

}  // namespace simuli::cli
