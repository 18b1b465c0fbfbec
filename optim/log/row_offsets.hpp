#pragma once
// How far rows of a LiDAR state their ranges from what the LiDAR set shows there: what is left of their range
// biases once a set has been fitted to all rows together.
#include <array>
#include <cstdint>
#include <vector>

#include "host/render/scene/ray_results.hpp"
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
  /// [rows] m, stated less shown: each row's median, less the median of the rows, as the set follows what all
  /// rows share. 0 for rows with too few returns.
  [[nodiscard]] std::vector<double> offsets() const;

 private:
  static constexpr std::size_t kBins = 600;  // of half a millimetre
  std::vector<std::array<std::uint64_t, kBins>> counts_;
};

}  // namespace simuli
