#pragma once
// Offsets between a LiDAR's ranges by row and the trained LiDAR set: the remaining range biases after a set was
// fitted to all rows together.
#include <array>
#include <cstdint>
#include <vector>

#include "host/device/render/scene/ray_results.hpp"
#include "io/log/log.hpp"

namespace simuli {

class RowOffsets {
 public:
  /// Returns farther from the rendered surface belong to something else.
  static constexpr double kFarthest_m = 0.15;
  /// Rows with fewer returns get no offset.
  static constexpr std::uint64_t kFewestReturns = 200;

  explicit RowOffsets(std::size_t rows);
  /// Adds a recorded sweep (after the known biases) and its rays rendered from the set.
  void add(const Sweep& sweep, const RayResults& seen);
  /// Returns [rows] m, recorded minus rendered: the mean of a row's medians by azimuth sector, minus the median
  /// over rows, because the set follows biases common to all rows. A row's own offset is equal in all
  /// directions, errors of the set are not, so the offset is shrunk by 1 - (sigma / offset)^2, at least 0, with
  /// sigma from the sectors. 0 below 3 mm, and for rows with few returns or sectors.
  [[nodiscard]] std::vector<double> offsets() const;

 private:
  static constexpr std::size_t kSectors = 8;
  static constexpr std::size_t kBins = 600;  // of half a millimetre
  using Counts = std::array<std::uint32_t, kBins>;
  /// Median in m; undefined without returns.
  [[nodiscard]] static double median_of(const Counts& counts, std::uint64_t all);
  std::vector<std::array<Counts, kSectors>> counts_;  // [rows]
};

}  // namespace simuli
