#pragma once
// Names of sensors, actors, scenes and logs. They come from untrusted files, and files are named after them.
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

/// Throws Error{kInput} for an invalid name: valid names have 1 to 128 bytes, no '/' or '\', no control
/// characters, and do not begin with a dot.
void need_name(std::string_view name, std::string_view file, std::string_view field);

/// Converts a name chosen by another program to a valid one: invalid characters become '_'.
[[nodiscard]] std::string name_from(std::string_view text);

/// Returns the index of `name` in `names`; throws Error{kUsage} that calls it a `what`.
[[nodiscard]] std::size_t index_of_name(std::string_view name,
                                        const std::vector<std::string>& names,
                                        std::string_view what);

}  // namespace simuli
