#pragma once
// How far rows of a LiDAR state their ranges from what the LiDAR set shows there: what is left of their range
// biases once a set has been fitted to all rows together.
#include <array>
#include <cstdint>
#include <vector>

#include "host/device/render/scene/ray_results.hpp"
#include "io/log/log.hpp"

namespace simuli {

class RowOffsets {
 public:
  /// Returns that are farther than this from what the set shows are of something else.
  static constexpr double kFarthest_m = 0.15;
  /// Fewer returns of a row tell nothing.
  static constexpr std::uint64_t kFewestReturns = 200;

  explicit RowOffsets(std::size_t rows);
  /// A sweep as its file states it (after the biases known so far), and what the set shows of its rays.
  void add(const Sweep& sweep, const RayResults& seen);
  /// [rows] m, stated less shown: the mean of a row's medians by sector of azimuth, less the median of the
  /// rows, as the set follows what all rows share. A row's own offset is the same in all directions, what the
  /// set does not know of the street is not: so it shrinks by 1 - (sigma / offset)^2, down to 0, sigma from
  /// the sectors. 0, too, below 3 mm, and for rows with few returns, or in few sectors.
  [[nodiscard]] std::vector<double> offsets() const;

 private:
  static constexpr std::size_t kSectors = 8;
  static constexpr std::size_t kBins = 600;  // of half a millimetre
  using Counts = std::array<std::uint32_t, kBins>;
  /// m; of no returns it can't be told.
  [[nodiscard]] static double median_of(const Counts& counts, std::uint64_t all);
  std::vector<std::array<Counts, kSectors>> counts_;  // [rows]
};

}  // namespace simuli
