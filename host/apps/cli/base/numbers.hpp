#pragma once
// Parses numbers in the value of an option: "0:1:0.1", "1,2,3", "640x480".
#include <cstddef>
#include <string>
#include <vector>

namespace simuli::cli {

/// Parses exactly `count` finite numbers separated by `separator`. Throws Error{kUsage} for other texts; the
/// message contains `allowed`, or a description of the numbers if `allowed` is empty.
[[nodiscard]] std::vector<double> parse_numbers(const char* option,
                                                const std::string& text,
                                                std::size_t count,
                                                char separator,
                                                const std::string& allowed = "");

}  // namespace simuli::cli
