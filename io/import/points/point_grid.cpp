#include "io/import/points/point_grid.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "io/import/kitti/kitti_parts.hpp"

namespace simuli {
namespace {

constexpr double kNearest_m = 0.1;       // closer points have no direction
constexpr double kTolerance_rad = 0.01;  // from a beam, unless a neighbouring beam is nearer than twice that
constexpr double kSameRay = 0.3;         // in columns

/// A ray as seen from its beam's own origin.
struct Ray {
  double azimuth = 0.0, elevation = 0.0, range = 0.0;
};

Ray ray_through(const Lidar& lidar, int row, const Eigen::Vector3d& p) {
  Ray ray{std::atan2(p.y(), p.x()), 0.0, 0.0};
  // The origin rotates with the azimuth and changes it by some mrad: two iterations reach float precision.
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d d = p - lidar.origin(row, ray.azimuth);
    ray = {std::atan2(d.y(), d.x()), std::atan2(d.z(), d.head<2>().norm()), d.norm()};
  }
  return ray;
}

struct Placed {
  double column = 0.0;
  Ray ray;
  const MeasuredPoint* point = nullptr;
};

/// Keeps the nearest point of each firing.
void keep_first_echoes(std::vector<Placed>& row, PointReport& report) {
  std::sort(row.begin(), row.end(), [](const Placed& a, const Placed& b) { return a.column < b.column; });
  std::vector<Placed> kept;
  for (const Placed& p : row) {
    if (kept.empty() || p.column - kept.back().column > kSameRay) {
      kept.push_back(p);
      continue;
    }
    ++report.echoes;
    if (p.ray.range < kept.back().ray.range) kept.back() = p;
  }
  row = std::move(kept);
}

/// Reduces the points to the number of columns: repeatedly removes the farther one of the two closest points.
void leave_as_many(std::vector<Placed>& row, std::size_t columns, PointReport& report) {
  while (row.size() > columns) {
    std::size_t closest = 1;
    for (std::size_t i = 2; i < row.size(); ++i) {
      const bool closer = row[i].column - row[i - 1].column < row[closest].column - row[closest - 1].column;
      if (closer) closest = i;
    }
    const std::size_t farther = row[closest].ray.range >= row[closest - 1].ray.range ? closest : closest - 1;
    row.erase(row.begin() + static_cast<std::ptrdiff_t>(farther));
    ++report.unplaced;
  }
}

/// Fills values[c] between columns with known values by linear interpolation, and with the nearest value
/// outside. Values are periodic with `period`: at a sweep's seam one neighbour has the end time and the next
/// one the start time, and no ray between them may get the middle. A single such ray would enlarge all
/// particles' boxes to the motion of a whole sweep (model.time_spread).
void spread(const std::vector<int>& columns,
            const std::vector<double>& off,
            double period,
            float* values,
            int count) {
  std::size_t next = 0;
  for (int c = 0; c < count; ++c) {
    while (next < columns.size() && columns[next] < c) ++next;
    double shift = 0.0;
    if (next == columns.size()) {
      shift = off.back();
    } else if (next == 0 || columns[next] == c) {
      shift = off[next];
    } else {
      const double u = static_cast<double>(c - columns[next - 1]) / (columns[next] - columns[next - 1]);
      const double turns = period * std::round((off[next] - off[next - 1]) / period);
      shift = (1.0 - u) * off[next - 1] + u * (off[next] - turns) + (u < 0.5 ? 0.0 : turns);
    }
    values[c] = static_cast<float>(values[c] + shift);
  }
}

}  // namespace

std::vector<double> row_tolerances(const Lidar& lidar) {
  std::vector<double> out;
  for (std::size_t r = 0; r < lidar.rows.size(); ++r) {
    double apart = 0.0;
    if (r > 0) apart = lidar.rows[r - 1].elevation - lidar.rows[r].elevation;
    if (r + 1 < lidar.rows.size()) {
      apart = std::max(apart, lidar.rows[r].elevation - lidar.rows[r + 1].elevation);
    }
    out.push_back(std::max(kTolerance_rad, 0.5 * apart));
  }
  return out;
}

int nearest_row(const Lidar& lidar, const std::vector<double>& tolerance, const Eigen::Vector3d& p) {
  int best = -1;
  double smallest = kPi;
  double offset = 0.0, elevation = std::atan2(p.z(), p.head<2>().norm());
  for (std::size_t r = 0; r < lidar.rows.size(); ++r) {
    const LidarRow& row = lidar.rows[r];
    if (row.vertical_offset != offset) {  // most beams have the same offset
      offset = row.vertical_offset;
      elevation = std::atan2(p.z() - offset, p.head<2>().norm());
    }
    const double off = std::abs(elevation - row.elevation);
    if (off > tolerance[r] || off >= smallest) continue;
    smallest = off;
    best = static_cast<int>(r);
  }
  return best;
}

double column_of(const Lidar& lidar, int row, double azimuth) {
  const double step = lidar.azimuth_span / lidar.columns;
  const double half = 0.5 * step;
  double ahead = std::fmod(lidar.spin_sign() * (azimuth - lidar.azimuth(row, 0)) + half, kTurn);
  if (ahead < 0.0) ahead += kTurn;
  return (ahead - half) / step;
}

Sweep grid_points(const std::vector<MeasuredPoint>& points, const Lidar& lidar, PointReport& report) {
  std::vector<std::vector<Placed>> rows(lidar.rows.size());
  const std::vector<double> tolerance = row_tolerances(lidar);
  for (const MeasuredPoint& point : points) {
    ++report.points;
    const bool far = point.position.norm() >= kNearest_m;
    const int row = !far ? -1 : point.row >= 0 ? point.row : nearest_row(lidar, tolerance, point.position);
    Placed placed{0.0, {}, &point};
    if (row >= 0) {
      placed.ray = ray_through(lidar, row, point.position);
      placed.column = column_of(lidar, row, placed.ray.azimuth);
    }
    if (row < 0 || placed.column > lidar.columns - 0.5) {
      ++report.unplaced;
    } else {
      rows[static_cast<std::size_t>(row)].push_back(placed);
    }
  }

  Sweep sweep;
  sweep.rays = nominal_rays(lidar);
  sweep.range.assign(lidar.ray_count(), 0.0F);
  sweep.intensity.assign(lidar.ray_count(), 0.0F);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const LidarRow& beam = lidar.rows[r];
    const int firings = firings_of(lidar, static_cast<int>(r));
    report.rays += static_cast<std::size_t>(firings);
    keep_first_echoes(rows[r], report);
    leave_as_many(rows[r], static_cast<std::size_t>(firings), report);
    if (rows[r].empty()) continue;
    const std::size_t first = r * static_cast<std::size_t>(lidar.columns);
    // in the convention of kitti::assign_columns(): clockwise from pi, a full revolution
    std::vector<double> even;
    for (const Placed& p : rows[r])
      even.push_back(kPi - ((p.column - beam.first) / beam.every + 0.5) * 2.0 * kPi / firings);
    std::vector<int> columns = kitti::assign_columns(even, firings);
    for (int& column : columns) column = beam.first + beam.every * column;
    std::vector<double> azimuth_off, time_off;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Placed& p = rows[r][i];
      const std::size_t ray = first + static_cast<std::size_t>(columns[i]);
      azimuth_off.push_back(std::remainder(p.ray.azimuth - double{sweep.rays.azimuth[ray]}, kTurn));
      const double own = p.point->time_fraction;
      time_off.push_back(std::isnan(own) ? 0.0 : own - double{sweep.rays.time_fraction[ray]});
      sweep.rays.elevation[ray] = static_cast<float>(p.ray.elevation);
      sweep.range[ray] = static_cast<float>(p.ray.range);
      sweep.intensity[ray] = p.point->intensity;
    }
    report.returned += columns.size();
    spread(columns, azimuth_off, kTurn, sweep.rays.azimuth.data() + first, lidar.columns);
    spread(columns,
           time_off,
           kTurn / lidar.azimuth_span,
           sweep.rays.time_fraction.data() + first,
           lidar.columns);
  }
  return sweep;
}

void need_placed(const PointReport& report, const std::string& file) {
  constexpr double kMostUnplaced = 0.05;
  if (static_cast<double>(report.unplaced) <= kMostUnplaced * static_cast<double>(report.points)) return;
  throw_input_error(file,
                    "points on no ray of their LiDAR",
                    fmt::format("{} of {}", report.unplaced, report.points),
                    fmt::format("at most {} %: is it that sensor?", 100.0 * kMostUnplaced));
}

}  // namespace simuli
