#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace simuli {

/// At most `most` of them, in their order, evenly spread.
[[nodiscard]] inline std::vector<std::size_t> evenly_spread(const std::vector<std::size_t>& all,
                                                            std::size_t most) {
  const std::size_t count = std::min(all.size(), most);
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

}  // namespace simuli
