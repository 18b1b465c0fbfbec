#pragma once
#include <string>
#include <vector>

namespace simuli {

/// Returns up to `most` of `known` that resemble `name`, the closest first: names that contain it, and names
/// that differ from it, or whose part after an underscore or dot differs from it, by few typing errors. Ignores
/// case.
[[nodiscard]] std::vector<std::string> close_names(const std::string& name,
                                                   const std::vector<std::string>& known,
                                                   std::size_t most = 5);

/// Returns "did you mean a, b? " for these; empty when none or all are close.
[[nodiscard]] std::string did_you_mean(const std::string& name, const std::vector<std::string>& known);

}  // namespace simuli
