#pragma once
// Names of sensors, actors, scenes and logs: they come from files of anybody, and files are named after them.
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace simuli {

/// Error{kInput} for what is no name: 1 to 128 bytes, no '/' and '\', no control characters, not beginning
/// with a dot.
void need_name(std::string_view name, std::string_view file, std::string_view field);

/// `text` as a name, for names that another program has chosen: what no name may hold becomes '_'.
[[nodiscard]] std::string name_from(std::string_view text);

/// Where `name` stands in `names`; Error{kUsage} that calls it a `what`.
[[nodiscard]] std::size_t index_of_name(std::string_view name,
                                        const std::vector<std::string>& names,
                                        std::string_view what);

}  // namespace simuli
