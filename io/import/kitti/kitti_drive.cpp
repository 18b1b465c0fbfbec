// Estimation of a drive's LiDAR from its sweeps, and reading of sweeps.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <variant>

#include "host/core/base/error.hpp"
#include "io/import/kitti/kitti.hpp"
#include "io/import/kitti/kitti_parts.hpp"
#include "io/log/sensor_file.hpp"

namespace simuli::kitti {
namespace {

namespace fs = std::filesystem;

/// A larger share of points on no beam indicates another sensor or a damaged file.
constexpr double kMostUnplaced = 0.005;
/// Largest relative deviation of the firings per revolution from the nominal number (8 and 12 Hz are far
/// outside).
constexpr double kColumnMargin = 0.04;

BeamPoints read_beams(const fs::path& file, const Lidar& lidar, std::size_t& points) {
  const std::vector<Point> read = read_points(file);
  points = read.size();
  return sort_into_beams(read, lidar);
}

void add_to_report(const Sweep& sweep, const Lidar& lidar, KittiReport& report) {
  report.rays += sweep.range.size();
  for (int r = 0; r < lidar.row_count(); ++r) {
    for (int c = 0; c < lidar.columns; ++c) {
      const auto ray =
          static_cast<std::size_t>(r) * static_cast<std::size_t>(lidar.columns) + static_cast<std::size_t>(c);
      if (sweep.range[ray] == 0.0F) continue;
      ++report.returned;
      const double shift =
          std::remainder(sweep.rays.azimuth[ray] - lidar.azimuth(r, c), 2.0 * std::numbers::pi);
      report.azimuth_shift_max_rad = std::max(report.azimuth_shift_max_rad, std::abs(shift));
    }
  }
}

}  // namespace

Lidar read_beam_table(const fs::path& file, double sweep_s) {
  if (file.empty()) {
    Lidar lidar = builtin_lidar("kitti_hdl64e");
    lidar.sweep_s = sweep_s;
    return lidar;
  }
  const LidarFile read = read_lidar_file(file);
  const auto* const table = std::get_if<Lidar>(&read.model);
  if (table == nullptr || table->spin != SpinDirection::kClockwise) {
    throw_input_error(file.string(),
                      table == nullptr ? "kind" : "spin",
                      table == nullptr ? "ray_list" : "counter_clockwise",
                      table == nullptr ? "lidar" : "clockwise, as KITTI's sensor turns");
  }
  Lidar lidar = *table;
  for (LidarRow& row : lidar.rows) {
    row.time_offset += row.azimuth_offset / (2.0 * std::numbers::pi) * sweep_s;
    row.azimuth_offset = 0.0;
  }
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.sweep_s = sweep_s;
  return lidar;
}

Lidar fit_lidar(const std::vector<fs::path>& files, Lidar lidar, KittiReport& report) {
  lidar.name = "velodyne";
  const int nominal = lidar.columns;
  double most_in_a_row = 0.0;
  std::vector<double> firings;  // per revolution, of sweeps with enough points
  for (const fs::path& file : files) {
    std::size_t points = 0;
    const BeamPoints beams = read_beams(file, lidar, points);
    report.points += points;
    report.unplaced += beams.unplaced;
    report.ring_agrees += beams.ring_agrees;
    if (static_cast<double>(beams.unplaced) > kMostUnplaced * static_cast<double>(points)) {
      throw_input_error(
          file.string(),
          "points outside every beam",
          fmt::format("{} of {}", beams.unplaced, points),
          fmt::format("at most {} % (another sensor: simuli fit beams)", 100.0 * kMostUnplaced));
    }
    const double estimate = estimate_columns(beams, lidar);
    if (estimate > 0.0) firings.push_back(estimate);
    for (std::size_t r = 0; r < beams.rows.size(); ++r) {
      most_in_a_row = std::max(most_in_a_row, static_cast<double>(beams.rows[r].size()));
      for (const Point& point : beams.rows[r]) {
        const double range = (point.position - lidar.origin(static_cast<int>(r), 0.0)).norm();
        lidar.range_min = std::min(lidar.range_min, range);
        lidar.range_max = std::max(lidar.range_max, range);
      }
    }
  }
  std::nth_element(
      firings.begin(), firings.begin() + static_cast<std::ptrdiff_t>(firings.size() / 2), firings.end());
  // The nominal number if there are too few points.
  const double typical = firings.empty() ? nominal : std::round(firings[firings.size() / 2]);
  const double columns = std::max(typical, most_in_a_row);
  if (!(std::abs(columns - nominal) <= nominal * kColumnMargin)) {
    throw_input_error(
        files.front().parent_path().string(),
        "firings per turn",
        fmt::format("{}", columns),
        fmt::format("{} within {} % (another sensor: simuli fit beams)", nominal, 100.0 * kColumnMargin));
  }
  lidar.columns = static_cast<int>(columns);
  lidar.azimuth_first = std::numbers::pi * (1.0 - 1.0 / lidar.columns);
  return lidar;
}

Sweep read_sweep_file(const fs::path& file, const Lidar& lidar, KittiReport& report) {
  std::size_t points = 0;
  const Sweep sweep = make_sweep(read_beams(file, lidar, points), lidar);
  add_to_report(sweep, lidar, report);
  return sweep;
}

}  // namespace simuli::kitti
