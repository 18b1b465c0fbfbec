#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace simuli {

/// Returns at most `most` elements in order, evenly spread.
[[nodiscard]] inline std::vector<std::size_t> evenly_spread(const std::vector<std::size_t>& all,
                                                            std::size_t most) {
  const std::size_t count = std::min(all.size(), most);
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

/// Returns the indices of `all` into `frames` whose frame is_own(frame), in order.
template <class Frame, class IsOwn>
[[nodiscard]] std::vector<std::size_t> own_of(const std::vector<std::size_t>& all,
                                              const std::vector<Frame>& frames,
                                              const IsOwn& is_own) {
  std::vector<std::size_t> own;
  for (const std::size_t i : all) {
    if (is_own(frames[i])) own.push_back(i);
  }
  return own;
}

}  // namespace simuli
