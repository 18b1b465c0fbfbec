#pragma once
#include <string>
#include <vector>

namespace simuli {

/// Up to `most` of `known` that resemble `name`, the closest first: those that hold it as a part, and those
/// from which, or from the end of which behind an underscore or a dot, it is few typing errors away.
[[nodiscard]] std::vector<std::string> close_names(const std::string& name,
                                                   const std::vector<std::string>& known,
                                                   std::size_t most = 5);

}  // namespace simuli
