#include "host/base/close_names.hpp"

#include <algorithm>
#include <utility>

namespace simuli {
namespace {

/// Levenshtein distance.
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> previous(b.size() + 1), current(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      current[j] = std::min({replaced, previous[j] + 1, current[j - 1] + 1});
    }
    std::swap(previous, current);
  }
  return previous[b.size()];
}

}  // namespace

std::vector<std::string> close_names(const std::string& name,
                                     const std::vector<std::string>& known_names,
                                     std::size_t most) {
  std::vector<std::pair<std::size_t, std::string>> ranked;
  for (const std::string& known : known_names) {
    // The best alignment with the name or with a part of it that underscores or dots set off: "os1_64", "hdl64".
    std::size_t best = edits(name, known);
    constexpr char kSetOff[] = "_.";
    for (std::size_t at = known.find_first_of(kSetOff); at != std::string::npos;
         at = known.find_first_of(kSetOff, at + 1)) {
      best = std::min(best, edits(name, known.substr(at + 1)));
    }
    if (name.size() >= 3 && known.find(name) != std::string::npos) best = std::min<std::size_t>(best, 1);
    if (best < name.size() && best <= std::max<std::size_t>(2, name.size() / 3))
      ranked.emplace_back(best, known);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::string> close;
  for (const auto& [distance, known] : ranked) {
    if (close.size() < most) close.push_back(known);
  }
  return close;
}

}  // namespace simuli
