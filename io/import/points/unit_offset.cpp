#include "io/import/points/unit_offset.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/spread.hpp"
#include "host/core/sensors/lidar_locate.hpp"
#include "io/import/points/point_grid.hpp"

namespace simuli {
namespace {

constexpr double kLargest_rad = 1.0 * kDegree;
constexpr double kStep_rad = 0.01 * kDegree;
constexpr double kWorthwhile_rad = 0.02 * kDegree;  // of a table's own mean error
constexpr double kBetter = 0.5;                     // required reduction of that error
constexpr double kCap_rad = 0.5 * kDegree;          // larger errors are not assigned to a beam
constexpr std::size_t kPoints = 2000;

// Constants of mountings.
constexpr double kAlone = 3.0;                 // times the usual gap to the next beam: an unambiguous beam
constexpr int kSteps = 6;                      // Gauss-Newton steps, each with a new assignment of beams
constexpr double kSharp_rad = 0.02 * kDegree;  // scale of the robust weights
// Prior standard deviations.
constexpr double kTurned_rad = 1.0 * kDegree, kMoved_m = 0.1;

/// Errors of points from the cones of the nearest beams, and the step that reduces them.
struct RowStep {
  double error = 0.0;  // rad, mean
  Pose step;
};

RowStep row_step(const Lidar& table,
                 const std::vector<double>& tolerances,
                 const std::vector<bool>& counts,
                 const std::vector<Eigen::Vector3d>& points,
                 const Pose& table_from_sensor) {
  using Vector5 = Eigen::Matrix<double, 5, 1>;  // rotation about x and y, translation
  Vector5 prior, right = Vector5::Zero();
  prior << 1.0 / kTurned_rad, 1.0 / kTurned_rad, Eigen::Vector3d::Constant(1.0 / kMoved_m);
  Eigen::Matrix<double, 5, 5> normal = prior.cwiseAbs2().asDiagonal();
  RowStep out;
  double count = 0.0;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = table_from_sensor * point;
    const int row = nearest_row(table, tolerances, p);
    if (row < 0 || !counts[static_cast<std::size_t>(row)]) continue;
    const LidarRow& beam = table.rows[static_cast<std::size_t>(row)];
    const Eigen::Vector3d d = p - Eigen::Vector3d(0.0, 0.0, beam.vertical_offset);
    const double across = d.head<2>().norm(), off = std::atan2(d.z(), across) - beam.elevation;
    const Eigen::Vector3d slope =
        Eigen::Vector3d(-d.z() * d.x() / across, -d.z() * d.y() / across, across) / d.squaredNorm();
    Vector5 by;
    by << p.cross(slope).head<2>(), slope;
    const double weight = 1.0 / (kSharp_rad * kSharp_rad + off * off);
    normal += weight * by * by.transpose();
    right -= weight * off * by;
    out.error += std::abs(off);
    count += 1.0;
  }
  out.error /= std::max(1.0, count);
  const Vector5 change = normal.ldlt().solve(right);
  const Eigen::Vector3d half(0.5 * change[0], 0.5 * change[1], 0.0);
  out.step = {Eigen::Quaterniond(1.0, half.x(), half.y(), half.z()).normalized(), change.tail<3>()};
  return out;
}

}  // namespace

double unit_offset(const Lidar& table, const std::vector<Eigen::Vector3d>& points) {
  // Elevation of each point above each beam.
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

UnitMounting unit_mounting(const Lidar& table, const std::vector<Eigen::Vector3d>& points) {
  const std::vector<double> tolerances = row_tolerances(table);
  std::vector<double> gaps(table.rows.size(), kTurn);
  for (std::size_t r = 0; r + 1 < gaps.size(); ++r) {
    const double gap = std::abs(table.rows[r].elevation - table.rows[r + 1].elevation);
    gaps[r] = std::min(gaps[r], gap);
    gaps[r + 1] = gap;
  }
  const std::vector<bool> all(gaps.size(), true);
  std::vector<bool> alone;
  for (const double gap : gaps) alone.push_back(gap >= kAlone * upper_median(gaps));
  const auto fit = [&](const std::vector<bool>& counts, Pose& pose) {
    for (int i = 0; i < kSteps; ++i) pose = row_step(table, tolerances, counts, points, pose).step * pose;
  };
  UnitMounting out;
  out.before_rad = out.left_rad = row_step(table, tolerances, all, points, {}).error;
  if (out.before_rad < kWorthwhile_rad) return out;
  // Isolated beams first: after their fit, points of dense beams are nearest to their own.
  Pose found;
  fit(alone, found);
  fit(all, found);
  const double left = row_step(table, tolerances, all, points, found).error;
  if (left > kBetter * out.before_rad) return out;
  out.table_from_sensor = found;
  out.left_rad = left;
  return out;
}

std::string raise_beams(Lidar& table, double offset) {
  for (LidarRow& row : table.rows) row.elevation += offset;
  return fmt::format("another unit: all beams {:.3f} degrees {} than the table's, by the points",
                     std::abs(offset) / kDegree,
                     offset > 0.0 ? "higher" : "lower");
}

}  // namespace simuli
