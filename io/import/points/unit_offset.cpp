#include "io/import/points/unit_offset.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/spread.hpp"
#include "host/core/sensors/lidar_locate.hpp"

namespace simuli {
namespace {

constexpr double kLargest_rad = 1.0 * kDegree;
constexpr double kStep_rad = 0.01 * kDegree;
constexpr double kWorthwhile_rad = 0.02 * kDegree;  // of a table's own mean error
constexpr double kBetter = 0.5;                     // of that error
constexpr double kCap_rad = 0.5 * kDegree;          // what is farther off is on no beam
constexpr std::size_t kPoints = 2000;

}  // namespace

double unit_offset(const Lidar& table, const std::vector<Eigen::Vector3d>& points) {
  // Of each point how far it is above each row.
  std::vector<std::vector<double>> off;
  for (std::size_t i = 0; i < points.size(); i += points.size() / kPoints + 1) {
    std::vector<double> rows;
    for (int row = 0; row < table.row_count(); ++row) {
      const auto hit = locate_in_row(table, row, points[i]);
      if (hit && std::abs(hit->elevation_error) < kLargest_rad + kCap_rad)
        rows.push_back(hit->elevation_error);
    }
    off.push_back(std::move(rows));
  }
  const auto nearest = [&](const std::vector<double>& rows, double offset) {
    double least = kCap_rad;
    for (const double row : rows) least = std::abs(row - offset) < std::abs(least) ? row - offset : least;
    return least;
  };
  const auto error = [&](double offset) {
    double sum = 0.0;
    for (const auto& rows : off) sum += std::abs(nearest(rows, offset));
    return sum / static_cast<double>(std::max<std::size_t>(1, off.size()));
  };
  const double as_it_is = error(0.0);
  if (as_it_is < kWorthwhile_rad) return 0.0;
  double best = 0.0, least = as_it_is;
  const int steps = static_cast<int>(std::lround(kLargest_rad / kStep_rad));
  for (int i = 1; i <= steps; ++i) {
    for (const double offset : {i * kStep_rad, -i * kStep_rad}) {
      const double value = error(offset);
      if (value >= least - 1e-9) continue;
      least = value;
      best = offset;
    }
  }
  if (least > kBetter * as_it_is) return 0.0;
  std::vector<double> rest;
  for (const auto& rows : off) {
    const double left = nearest(rows, best);
    if (std::abs(left) < kCap_rad) rest.push_back(left);
  }
  return rest.empty() ? 0.0 : best + upper_median(std::move(rest));
}

std::string raise_beams(Lidar& table, double offset) {
  for (LidarRow& row : table.rows) row.elevation += offset;
  return fmt::format("another unit: all beams {:.3f} degrees {} than the table's, by the points",
                     std::abs(offset) / kDegree,
                     offset > 0.0 ? "higher" : "lower");
}

}  // namespace simuli
