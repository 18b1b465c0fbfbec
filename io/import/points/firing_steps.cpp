#include "io/import/points/firing_steps.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <map>
#include <set>

#include "host/core/base/angles.hpp"

namespace simuli {
namespace {

constexpr double kSameRay_rad = 3.5e-4;  // closer points are echoes; 18 000 firings per revolution
constexpr std::size_t kFewest = 20;      // neighbours that determine a step
constexpr double kOneStep = 0.3;         // of the median step, for rounding encoders and beams off the axis
constexpr double kMostClean = 0.6;       // of all neighbours
constexpr double kFewestRuns = 0.2;      // share of the runs with enough points

/// Returns the mean step of a run; 0 if most neighbours are farther apart.
double step_of(FiredRun azimuths) {
  for (double& azimuth : azimuths) azimuth -= kTurn * std::floor(azimuth / kTurn);
  std::sort(azimuths.begin(), azimuths.end());
  std::vector<double> steps;
  for (std::size_t i = 1; i < azimuths.size(); ++i) {
    const double step = azimuths[i] - azimuths[i - 1];
    if (step > kSameRay_rad) steps.push_back(step);
  }
  if (steps.size() < kFewest) return 0.0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double median = *middle;
  double sum = 0.0;
  std::size_t count = 0;
  for (const double step : steps) {
    if (std::abs(step - median) > kOneStep * median) continue;
    sum += step;
    ++count;
  }
  return static_cast<double>(count) < kMostClean * static_cast<double>(steps.size())
             ? 0.0
             : sum / static_cast<double>(count);
}

struct Pattern {
  int every = 0;  // 0: unknown
  int first = 0;
};

/// Returns the most frequent distance of neighbours in columns.
long most_apart(const std::vector<double>& columns) {
  std::set<long> at;
  for (const double column : columns) at.insert(std::lround(column));
  std::map<long, int> steps{{1, 0}};
  for (auto it = std::next(at.begin()); it != at.end(); ++it) ++steps[*it - *std::prev(it)];
  const auto is_rarer = [](const auto& a, const auto& b) { return a.second < b.second; };
  return std::max_element(steps.begin(), steps.end(), is_rarer)->first;
}

/// Returns the firing pattern of a beam from the columns of its points.
Pattern pattern_of(const std::vector<double>& columns) {
  constexpr double kOnGrid = 0.8;
  if (columns.size() < kFewest) return {};
  for (const int every : {4, 3, 2, 1}) {
    std::complex<double> phase;
    for (const double column : columns) phase += std::polar(1.0, kTurn * column / every);
    if (std::abs(phase) < kOnGrid * static_cast<double>(columns.size())) continue;
    if (most_apart(columns) > every) return {};  // thinned irregularly
    const int first = static_cast<int>(std::lround(std::arg(phase) / kTurn * every));
    return {every, (first + every) % every};
  }
  return {};
}

}  // namespace

double columns_by_steps(const std::vector<FiredRun>& runs, double span) {
  std::vector<double> steps;
  std::size_t requested = 0;
  for (const FiredRun& run : runs) {
    if (run.size() <= kFewest) continue;
    ++requested;
    const double step = step_of(run);
    if (step > 0.0) steps.push_back(step);
  }
  const double needed = kFewestRuns * static_cast<double>(requested);
  if (steps.empty() || static_cast<double>(steps.size()) < needed) return 0.0;
  // The fastest rate that a fifth of the beams have, to exclude beams with few far points.
  const auto fast = steps.begin() +
                    static_cast<std::ptrdiff_t>(std::min(steps.size() - 1, static_cast<std::size_t>(needed)));
  std::nth_element(steps.begin(), fast, steps.end());
  const double step = *fast;
  double sum = 0.0, count = 0.0;
  for (const double other : steps) {
    if (std::abs(other - step) > kOneStep * step) continue;
    sum += other;
    count += 1.0;
  }
  return span * count / sum;
}

double fit_of_step(const std::vector<FiredRun>& runs, double step) {
  double sum = 0.0, count = 0.0;
  for (const FiredRun& run : runs) {
    if (run.size() < 2) continue;
    std::complex<double> phases;
    for (const double azimuth : run) phases += std::polar(1.0, kTurn * azimuth / step);
    sum += std::abs(phases);
    count += static_cast<double>(run.size());
  }
  return count > 0.0 ? sum / count : 0.0;
}

int set_firing_pattern(const std::vector<FiredRun>& runs, Lidar& lidar) {
  const std::size_t rows = lidar.rows.size();
  std::vector<std::vector<double>> columns(rows);
  std::complex<double> phase;
  double count = 0.0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const int row = static_cast<int>(i % rows);
    for (const double azimuth : runs[i]) {
      const double column =
          lidar.spin_sign() * (azimuth - lidar.azimuth(row, 0)) * lidar.columns / lidar.azimuth_span;
      columns[i % rows].push_back(column);
      phase += std::polar(1.0, kTurn * column);
      count += 1.0;
    }
  }
  constexpr double kSeen = 0.5;
  if (!(std::abs(phase) > kSeen * count)) return 0;
  const double shift = std::arg(phase) / kTurn;
  std::vector<Pattern> found;
  std::size_t reported = 0, always = 0;
  for (std::vector<double>& row : columns) {
    for (double& column : row) column -= shift;
    found.push_back(pattern_of(row));
    reported += found.back().every > 0 ? 1 : 0;
    always += found.back().every == 1 ? 1 : 0;
  }
  const bool has_pattern =
      std::any_of(lidar.rows.begin(), lidar.rows.end(), [](const LidarRow& row) { return row.every > 1; });
  // Clouds with every beam thinned do not determine the sensor's rate.
  if (static_cast<double>(always) < kFewestRuns * static_cast<double>(reported)) return 0;
  if (reported == 0 || (always == reported && !has_pattern)) return 0;
  lidar.azimuth_first += lidar.spin_sign() * shift * lidar.azimuth_span / lidar.columns;
  int changed = 0;
  for (std::size_t r = 0; r < rows; ++r) {
    LidarRow& row = lidar.rows[r];
    if (found[r].every == 0) continue;
    changed += found[r].every != row.every ? 1 : 0;
    row.every = found[r].every;
    row.first = found[r].first;
  }
  return changed;
}

}  // namespace simuli
