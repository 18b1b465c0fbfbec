#include "host/core/base/close_names.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "host/core/base/split.hpp"

namespace simuli {
namespace {

/// Number of typing errors between two words: inserted, deleted or replaced letters, or transposed neighbours.
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), previous(b.size() + 1), current(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      current[j] = std::min({replaced, previous[j] + 1, current[j - 1] + 1});
      const bool are_swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (are_swapped) current[j] = std::min(current[j], before[j - 2] + 1);
    }
    std::swap(before, previous);
    std::swap(previous, current);
  }
  return previous[b.size()];
}

}  // namespace

std::vector<std::string> close_names(const std::string& given,
                                     const std::vector<std::string>& known_names,
                                     std::size_t most) {
  const std::string name = lower(given);
  // One error in a short name is as ambiguous as two in a longer one.
  const std::size_t most_edits = name.size() < 5 ? 1 : std::max<std::size_t>(2, name.size() / 3);
  std::vector<std::pair<std::size_t, std::string>> ranked;
  for (const std::string& known_name : known_names) {
    const std::string known = lower(known_name);
    // Best match with the name or with a part of it between underscores or dots: "os1_64", "hdl64".
    std::size_t best = edits(name, known);
    constexpr char kSetOff[] = "_.";
    for (std::size_t at = known.find_first_of(kSetOff); at != std::string::npos;
         at = known.find_first_of(kSetOff, at + 1)) {
      best = std::min(best, edits(name, known.substr(at + 1)));
    }
    if (name.size() >= 3 && known.find(name) != std::string::npos) best = std::min<std::size_t>(best, 1);
    if (best < name.size() && best <= most_edits) ranked.emplace_back(best, known_name);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::string> close;
  for (const auto& [distance, known] : ranked) {
    if (close.size() < most) close.push_back(known);
  }
  return close;
}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& known) {
  const std::vector<std::string> close = close_names(name, known);
  return close.empty() || close.size() == known.size() ? "" : fmt::format("did you mean {}? ", fmt::join(close, ", "));
}

}  // namespace simuli
