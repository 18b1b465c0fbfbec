#include "optim/log/row_offsets.hpp"

#include <cmath>
#include <numeric>
#include <utility>

#include "host/base/error.hpp"
#include "optim/base/metrics.hpp"

namespace simuli {

RowOffsets::RowOffsets(std::size_t rows) : counts_(rows) {}

void RowOffsets::add(const Sweep& sweep, const RayResults& seen) {
  const std::size_t columns = counts_.empty() ? 0 : sweep.range.size() / counts_.size();
  if (columns * counts_.size() != sweep.range.size() || seen.rays != sweep.range.size()) {
    throw Error(ErrorKind::kInternal, "RowOffsets: sweep, rows and rays do not fit together");
  }
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    const double stated_m = sweep.range[i], shown_m = seen.expected_distance(i);
    if (!(stated_m > 0.0 && shown_m > 0.0)) continue;
    const double bin = (stated_m - shown_m + kFarthest_m) / (2.0 * kFarthest_m) * kBins;
    if (bin >= 0.0 && bin < kBins) ++counts_[i / columns][static_cast<std::size_t>(bin)];
  }
}

std::vector<double> RowOffsets::offsets() const {
  std::vector<double> out(counts_.size(), 0.0), told;
  std::vector<bool> is_told(counts_.size(), false);
  for (std::size_t row = 0; row < counts_.size(); ++row) {
    const std::uint64_t all = std::accumulate(counts_[row].begin(), counts_[row].end(), std::uint64_t{0});
    if (all < kFewestReturns) continue;
    std::uint64_t below = 0;
    std::size_t bin = 0;
    while (2 * (below + counts_[row][bin]) < all) below += counts_[row][bin++];
    const double within = (0.5 * static_cast<double>(all) - static_cast<double>(below)) /
                          static_cast<double>(counts_[row][bin]);
    out[row] = (static_cast<double>(bin) + within) / kBins * 2.0 * kFarthest_m - kFarthest_m;
    is_told[row] = true;
    told.push_back(out[row]);
  }
  if (told.empty()) return out;
  const double middle = median(std::move(told));
  for (std::size_t row = 0; row < out.size(); ++row) {
    if (is_told[row]) out[row] -= middle;
  }
  return out;
}

}  // namespace simuli
