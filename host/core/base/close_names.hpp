#pragma once
#include <string>
#include <vector>

namespace simuli {

/// Up to `most` of `known` that resemble `name`, the closest first: those that hold it as a part, and those
/// from which, or from the end of which behind an underscore or a dot, it is few typing errors away. Capitals
/// count as small letters.
[[nodiscard]] std::vector<std::string> close_names(const std::string& name,
                                                   const std::vector<std::string>& known,
                                                   std::size_t most = 5);

/// "did you mean a, b? " of those; empty where that says nothing: none of them is close, or all are.
[[nodiscard]] std::string did_you_mean(const std::string& name, const std::vector<std::string>& known);

}  // namespace simuli
