#include "optim/calibration/beams/beams.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <ceres/ceres.h>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/spread.hpp"
#include "optim/calibration/beams/beam_parts.hpp"

namespace simuli::calibration {
namespace {

constexpr double kNearest_m = 0.05;  // nearer points have no direction
constexpr std::size_t kVoters = 120000;
constexpr std::size_t kFewestVoters = 2000;
constexpr double kBin_rad = 0.25e-3;
constexpr double kTallest_m = 0.5;  // extent of the sensor's head above and below its origin
constexpr double kHeightStep_m = 0.01;
constexpr std::size_t kMostRows = 512;
constexpr double kGate_rad = 0.6e-3;  // tolerance of a beam's points about its line

/// A line in the plane of axis distance and height.
struct Line {
  double elevation = 0.0;  // rad
  double height = 0.0;     // m, intersection with the axis

  /// Sine of the angle, from the origin, of a point above the line.
  [[nodiscard]] double error(double distance, double z) const {
    return ((z - height) * std::cos(elevation) - distance * std::sin(elevation)) / std::hypot(distance, z);
  }
};

struct Voter {
  double distance;
  double height;
};

/// Votes of points for lines: rows are heights, columns elevations.
class VoteTable {
 public:
  explicit VoteTable(const std::vector<Voter>& voters) : votes_(kHeights * kBins) {
    for (const Voter& voter : voters) count(voter, 1);
  }
  void count(const Voter& voter, int weight) {
    for (std::size_t h = 0; h < kHeights; ++h) {
      const double elevation = std::atan2(voter.height - height_of(h), voter.distance);
      const double bin = std::clamp((elevation + kPi / 2) / kBin_rad, 0.0, static_cast<double>(kBins - 1));
      votes_[h * kBins + static_cast<std::size_t>(bin)] += weight;
    }
  }
  /// The line with most votes, including those of neighbouring elevations.
  [[nodiscard]] Line best() const {
    std::size_t place = 0;
    int most = -1;
    for (std::size_t h = 0; h < kHeights; ++h) {
      const int* const row = votes_.data() + h * kBins;
      for (std::size_t b = 0; b + 1 < kBins; ++b) {
        if (row[b] + row[b + 1] <= most) continue;
        most = row[b] + row[b + 1];
        place = h * kBins + b;
      }
    }
    return {static_cast<double>(place % kBins + 1) * kBin_rad - kPi / 2, height_of(place / kBins)};
  }

 private:
  static constexpr std::size_t kHeights = 2 * static_cast<std::size_t>(kTallest_m / kHeightStep_m + 0.5) + 1;
  static constexpr std::size_t kBins = static_cast<std::size_t>(kPi / kBin_rad) + 1;
  [[nodiscard]] static double height_of(std::size_t h) {
    return static_cast<double>(h) * kHeightStep_m - kTallest_m;
  }
  std::vector<int> votes_;
};

/// Least squares over the points within gate_rad; false with too few, or all at one distance.
bool fit_line(const std::vector<Voter>& voters, double gate_rad, Line& line) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Voter& v : voters) {
    if (!(std::abs(line.error(v.distance, v.height)) <= gate_rad)) continue;
    const double range2 = v.distance * v.distance + v.height * v.height;
    const Eigen::Vector2d a(v.distance, 1.0);
    normal += a * a.transpose() / range2;
    right += a * v.height / range2;
  }
  if (!(normal.determinant() > 1e-6 * normal(0, 0) * normal(1, 1))) return false;
  const Eigen::Vector2d slope_height = normal.inverse() * right;
  if (!(std::abs(slope_height[1]) <= kTallest_m)) return false;
  line = {std::atan(slope_height[0]), slope_height[1]};
  return true;
}

/// Repeatedly fits the line with most votes and removes the votes of its points.
std::vector<Line> find_lines(std::vector<Voter> voters) {
  VoteTable votes(voters);
  const std::size_t all = voters.size();
  std::vector<Line> lines;
  while (lines.size() < kMostRows && voters.size() > all / 500) {
    Line line = votes.best();
    for (const double gate_rad : {1e-3, 0.5e-3, 0.3e-3, 0.3e-3}) {
      if (!fit_line(voters, gate_rad, line)) break;
    }
    const auto kept = std::stable_partition(voters.begin(), voters.end(), [&](const Voter& v) {
      return std::abs(line.error(v.distance, v.height)) > kGate_rad;
    });
    const auto found = static_cast<std::size_t>(voters.end() - kept);
    if (found < std::max<std::size_t>(50, all / 2000)) break;
    for (auto v = kept; v != voters.end(); ++v) votes.count(*v, -1);
    voters.erase(kept, voters.end());
    lines.push_back(line);
  }
  std::sort(
      lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.elevation > b.elevation; });
  return lines;
}

/// Angle of a point above its beam, which leaves the axis at `height` and passes beside it.
struct ConeError {
  double along;  // m, from the beam's closest point to the axis
  double z;
  double range;
  double sigma_rad;

  template <class T>
  bool operator()(const T* elevation, const T* height, T* out) const {
    out[0] = ((T(z) - height[0]) * cos(elevation[0]) - T(along) * sin(elevation[0])) / T(range * sigma_rad);
    return true;
  }
};

/// At most kPerBin points per distance class, evenly: distant points are few and most informative.
std::vector<BeamPoint> choose(const std::vector<std::vector<BeamPoint>>& sweeps) {
  constexpr std::size_t kPerBin = 300;
  constexpr double kBinsPerDoubling = 3.0;
  std::array<std::vector<BeamPoint>, 32> classes;
  for (const auto& sweep : sweeps) {
    for (const BeamPoint& p : sweep) {
      const double place = std::clamp(kBinsPerDoubling * std::log2(p.distance), 0.0, 31.0);
      classes[static_cast<std::size_t>(place)].push_back(p);
    }
  }
  std::vector<BeamPoint> chosen;
  for (const auto& members : classes) {
    const std::size_t count = std::min(members.size(), kPerBin);
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(members[i * members.size() / count]);
  }
  return chosen;
}

/// Variances of two parameters of a solved problem; no value where the residuals only determine one. (Ceres'
/// own covariance logs that on stderr.)
std::optional<Eigen::Vector2d> variances(ceres::Problem& problem, double& first, double& second) {
  if (problem.NumResiduals() == 0) return {};
  ceres::Problem::EvaluateOptions of;
  of.parameter_blocks = {&first, &second};
  ceres::CRSMatrix jacobian;
  if (!problem.Evaluate(of, nullptr, nullptr, nullptr, &jacobian)) return {};
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>> j(
      jacobian.values.data(), jacobian.num_rows, 2);
  const Eigen::Matrix2d normal = j.transpose() * j;
  constexpr double kLeastCondition = 1e-14;  // reciprocal, of the normal equations
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(normal, Eigen::EigenvaluesOnly);
  const Eigen::Vector2d& values = solver.eigenvalues();
  if (!(values[0] > kLeastCondition * values[1])) return {};
  return normal.inverse().diagonal();
}

void fit_beam(const std::vector<std::vector<BeamPoint>>& sweeps, BeamEstimate& beam) {
  constexpr double kSigma_rad = 0.05e-3;
  const std::vector<BeamPoint> points = choose(sweeps);
  double elevation = beam.row.elevation;
  double height = beam.row.vertical_offset;
  const double side = beam.row.horizontal_offset;
  ceres::Problem problem;
  auto* const loss = new ceres::CauchyLoss(2.0);
  for (const BeamPoint& p : points) {
    const double along = std::sqrt(std::max(0.0, p.distance * p.distance - side * side));
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ConeError, 1, 1, 1>(new ConeError{
                                 along, p.height, std::hypot(p.distance, p.height), kSigma_rad}),
                             loss,
                             &elevation,
                             &height);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  std::vector<double> errors;
  const Line line{elevation, height};
  for (const BeamPoint& p : points) {
    errors.push_back(
        std::abs(line.error(std::sqrt(std::max(0.0, p.distance * p.distance - side * side)), p.height)));
  }
  beam.residual = 1.4826 * upper_median(std::move(errors));

  const std::optional<Eigen::Vector2d> variance =
      summary.IsSolutionUsable() ? variances(problem, elevation, height) : std::nullopt;
  const bool determined = variance.has_value();
  const double scale = std::max(beam.residual, 0.01e-3) / kSigma_rad;
  beam.elevation_sigma = determined ? scale * std::sqrt(variance->x()) : INFINITY;
  beam.vertical_offset_sigma = determined ? scale * std::sqrt(variance->y()) : INFINITY;
  beam.vertical_offset_known = beam.vertical_offset_sigma <= kWorstOffset_m;
  if (!determined) return;
  beam.row.elevation = elevation;
  beam.row.vertical_offset = height;
}

/// A row whose returns all have similar ranges does not determine both numbers: it takes the neighbouring rows'
/// offset, and the matching elevation.
void borrow_offsets(const BeamPoints& points, BeamTable& table) {
  std::size_t unknown = 0;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    BeamEstimate& beam = table.rows[r];
    if (beam.vertical_offset_known) continue;
    ++unknown;
    double offset_m = 0.0;
    for (std::size_t away = 1; away < table.rows.size(); ++away) {
      const bool above = r >= away && table.rows[r - away].vertical_offset_known;
      const bool below = r + away < table.rows.size() && table.rows[r + away].vertical_offset_known;
      if (!above && !below) continue;
      offset_m = table.rows[above ? r - away : r + away].row.vertical_offset;
      break;
    }
    std::vector<double> elevations;
    for (const auto& sweep : points[r]) {
      for (const BeamPoint& p : sweep) elevations.push_back(std::atan2(p.height - offset_m, p.distance));
    }
    if (!elevations.empty()) beam.row.elevation = upper_median(std::move(elevations));
    beam.row.vertical_offset = offset_m;
  }
  if (unknown > 0) {
    table.notes.push_back(
        fmt::format("vertical offset of {} of {} rows: not determined, their returns are all about as far "
                    "away; taken from "
                    "neighbouring beams",
                    unknown,
                    table.rows.size()));
  }
}

/// Assigns every point to its nearest beam.
BeamPoints sort_points(const std::vector<RawSweep>& sweeps, BeamTable& table) {
  std::vector<Line> lines;
  for (const BeamEstimate& beam : table.rows) lines.push_back({beam.row.elevation, beam.row.vertical_offset});
  BeamPoints points(lines.size(), std::vector<std::vector<BeamPoint>>(sweeps.size()));
  table.unplaced = 0;
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    for (const Eigen::Vector3d& p : sweeps[s]) {
      if (!(p.norm() >= kNearestTelling_m)) continue;
      const BeamPoint point{std::atan2(p.y(), p.x()), std::hypot(p.x(), p.y()), p.z()};
      std::size_t best = lines.size();
      double smallest = kGate_rad;
      for (std::size_t r = 0; r < lines.size(); ++r) {
        const double error = std::abs(lines[r].error(point.distance, point.height));
        if (error > smallest) continue;
        smallest = error;
        best = r;
      }
      if (best == lines.size()) {
        ++table.unplaced;
      } else {
        points[best][s].push_back(point);
      }
    }
  }
  for (std::size_t r = 0; r < lines.size(); ++r) {
    table.rows[r].points = 0;
    for (auto& sweep : points[r]) {
      table.rows[r].points += sweep.size();
      std::sort(sweep.begin(), sweep.end(), [](const BeamPoint& a, const BeamPoint& b) {
        return a.azimuth < b.azimuth;
      });
    }
  }
  return points;
}

}  // namespace

BeamTable find_beams(const std::vector<RawSweep>& sweeps) {
  BeamTable table;
  table.range_min = kNearestTelling_m;
  for (const RawSweep& sweep : sweeps) table.points += sweep.size();
  const std::size_t stride = std::max<std::size_t>(1, table.points / kVoters);
  std::vector<Voter> voters;
  std::size_t number = 0;
  for (const RawSweep& sweep : sweeps) {
    for (const Eigen::Vector3d& p : sweep) {
      const double range = p.norm();
      table.range_max = std::max(table.range_max, range);
      if (range >= kNearest_m) table.range_min = std::min(table.range_min, range);
      if (!(range >= kNearestTelling_m)) ++table.near;
      if (number++ % stride != 0 || !(range >= kNearestTelling_m)) continue;
      voters.push_back({std::hypot(p.x(), p.y()), p.z()});
    }
  }
  const auto refuse = [](const std::string& why) { throw Error(ErrorKind::kNumeric, "beam table: " + why); };
  if (voters.size() < kFewestVoters) {
    refuse(fmt::format("found {} points {} m away or farther, allowed at least {}",
                       voters.size(),
                       kNearestTelling_m,
                       kFewestVoters));
  }
  for (const Line& line : find_lines(std::move(voters))) {
    BeamEstimate beam;
    beam.row.elevation = line.elevation;
    beam.row.vertical_offset = line.height;
    table.rows.push_back(beam);
  }
  constexpr double kMostUnplaced = 0.05;
  BeamPoints points = sort_points(sweeps, table);
  const double unplaced =
      static_cast<double>(table.unplaced) / static_cast<double>(table.points - table.near);
  if (!(unplaced <= kMostUnplaced)) {
    refuse(
        fmt::format("found {:.1f} % of the points on no beam, allowed {:.0f} %: no spinning sensor with an "
                    "upright axis, or its motion is compensated already",
                    100.0 * unplaced,
                    100.0 * kMostUnplaced));
  }
  find_azimuths(points, table);
  for (std::size_t r = 0; r < table.rows.size(); ++r) fit_beam(points[r], table.rows[r]);
  borrow_offsets(points, table);
  std::stable_sort(table.rows.begin(), table.rows.end(), [](const BeamEstimate& a, const BeamEstimate& b) {
    return a.row.elevation > b.row.elevation;
  });
  points = sort_points(sweeps, table);
  return table;
}

Lidar lidar_of(const BeamTable& table, const std::string& name, SpinDirection spin) {
  Lidar lidar;
  lidar.name = name;
  lidar.spin = spin;
  lidar.columns = static_cast<int>(std::lround(table.columns));
  lidar.azimuth_span = 2.0 * kPi;
  lidar.azimuth_first = lidar.spin_sign() * kPi * (1.0 / std::max(1, lidar.columns) - 1.0);
  lidar.range_min = table.range_min;
  lidar.range_max = std::max(120.0, table.range_max);
  double mean_offset = 0.0;
  for (const BeamEstimate& beam : table.rows) {
    mean_offset += beam.row.azimuth_offset / static_cast<double>(table.rows.size());
  }
  for (const BeamEstimate& beam : table.rows) {
    lidar.rows.push_back(beam.row);
    lidar.rows.back().azimuth_offset -= mean_offset;
  }
  return lidar;
}

}  // namespace simuli::calibration
