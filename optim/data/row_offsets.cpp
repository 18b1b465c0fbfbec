#include "optim/data/row_offsets.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "host/core/base/error.hpp"
#include "optim/base/metrics.hpp"

namespace simuli {
namespace {

constexpr std::uint64_t kFewestInSector = 25;
constexpr std::size_t kFewestSectors = 4;
constexpr double kLeast_m = 0.003;

}  // namespace

RowOffsets::RowOffsets(std::size_t rows) : counts_(rows) {}

void RowOffsets::add(const Sweep& sweep, const RayResults& seen) {
  const std::size_t rays = sweep.range.size();
  const std::size_t columns = counts_.empty() ? 0 : rays / counts_.size();
  if (columns * counts_.size() != rays || seen.rays != rays || sweep.rays.azimuth.size() != rays) {
    throw Error(ErrorKind::kInternal, "RowOffsets: sweep, rows and rays do not fit together");
  }
  for (std::size_t i = 0; i < rays; ++i) {
    const double stated_m = sweep.range[i], shown_m = seen.expected_distance(i);
    if (!(stated_m > 0.0 && shown_m > 0.0)) continue;
    const double bin = (stated_m - shown_m + kFarthest_m) / (2.0 * kFarthest_m) * kBins;
    if (!(bin >= 0.0 && bin < kBins)) continue;
    const double turns = static_cast<double>(sweep.rays.azimuth[i]) / (2.0 * std::numbers::pi);
    const auto sector = static_cast<std::size_t>((turns - std::floor(turns)) * kSectors);
    ++counts_[i / columns][std::min(sector, kSectors - 1)][static_cast<std::size_t>(bin)];
  }
}

double RowOffsets::median_of(const Counts& counts, std::uint64_t all) {
  std::uint64_t below = 0;
  std::size_t bin = 0;
  while (2 * (below + counts[bin]) < all) below += counts[bin++];
  const double within = (0.5 * static_cast<double>(all) - static_cast<double>(below)) / counts[bin];
  return (static_cast<double>(bin) + within) / kBins * 2.0 * kFarthest_m - kFarthest_m;
}

std::vector<double> RowOffsets::offsets() const {
  struct Told {
    std::size_t row;
    double offset_m, variance_m2;
  };
  std::vector<Told> reported;
  std::vector<double> means;
  for (std::size_t row = 0; row < counts_.size(); ++row) {
    std::uint64_t returns = 0;
    double sum = 0.0, squares = 0.0;
    std::size_t sectors = 0;
    for (const Counts& sector : counts_[row]) {
      const std::uint64_t here = std::accumulate(sector.begin(), sector.end(), std::uint64_t{0});
      returns += here;
      if (here < kFewestInSector) continue;
      const double offset_m = median_of(sector, here);
      sum += offset_m;
      squares += offset_m * offset_m;
      ++sectors;
    }
    if (returns < kFewestReturns || sectors < kFewestSectors) continue;
    const auto n = static_cast<double>(sectors);
    means.push_back(sum / n);
    reported.push_back({row, means.back(), std::max(0.0, squares - sum * sum / n) / (n * (n - 1.0))});
  }
  std::vector<double> out(counts_.size(), 0.0);
  if (reported.empty()) return out;
  const double middle = median(std::move(means));
  for (const Told& t : reported) {
    const double offset_m = t.offset_m - middle;
    const double square_m2 = offset_m * offset_m;
    if (square_m2 > std::max(t.variance_m2, kLeast_m * kLeast_m)) {
      out[t.row] = offset_m * (1.0 - t.variance_m2 / square_m2);
    }
  }
  return out;
}

}  // namespace simuli
