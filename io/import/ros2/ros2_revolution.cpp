#include "io/import/ros2/ros2_revolution.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/sensors/lidar_library.hpp"
#include "host/core/sensors/lidar_locate.hpp"
#include "io/import/points/firing_steps.hpp"
#include "io/import/points/point_grid.hpp"

namespace simuli::ros2 {
namespace {

constexpr double kShortest_s = 0.01;  // no LiDAR rotates faster
constexpr double kSameRate = 0.1;     // relative tolerance of a mode's rate; sensors offer 5, 10, 15, 20 Hz
constexpr double kSameTurn = 0.03;    // relative tolerance of two measurements of one revolution
constexpr double kSameColumns = 0.08;
constexpr double kThinned = 4.0;  // fewer columns than any mode by this factor are not a mode
constexpr char kUnit[] = "--point-time FIELD:UNIT for another unit";

/// A point relative to its beam.
struct Fired {
  double turned;  // share of a revolution, counter-clockwise, minus the beam's offset
  double time_s;  // minus the beam's offset
};

bool is_near(double a, double b, double share) { return std::abs(a - b) <= share * b; }

class RevolutionFinder {
 public:
  RevolutionFinder(const Ros2Lidar& requested,
                   double apart_s,
                   const std::string& file,
                   const std::string& where)
      : requested_(requested), apart_s_(apart_s), file_(file), where_(where), modes_(requested.modes) {
    if (modes_.empty()) modes_ = {{1.0 / requested.table.sweep_s, requested.table.columns}};
  }

  RecordedRevolution found(const std::vector<std::vector<CloudPoint>>& sweeps,
                           const std::vector<int>& row_of) {
    read(sweeps, row_of);
    const double steps = columns_by_steps(runs_, requested_.table.azimuth_span);
    // The times of an oscillating LiDAR do not determine a revolution.
    const bool turns = std::abs(requested_.table.azimuth_span - kTurn) < 1e-6;
    const bool has_times =
        turns && std::any_of(fired_.begin(), fired_.end(), [](const auto& sweep) { return !sweep.empty(); });
    const double revolution_s = has_times ? by_times() : by_modes(steps);
    print_lost(revolution_s);
    const LidarMode mode = mode_of(revolution_s, steps);
    RecordedRevolution out{requested_.table, {}, {}};
    const bool is_other =
        mode.columns != out.model.columns || !is_near(out.model.sweep_s, revolution_s, kSameRate);
    if (is_other) {
      out.model = in_mode(out.model, mode);
      notes_.push_back(fmt::format("{} columns at {:.4g} Hz, not {} at {:.4g}, by the points",
                                   mode.columns,
                                   1.0 / revolution_s,
                                   requested_.table.columns,
                                   1.0 / requested_.table.sweep_s));
    }
    out.model.sweep_s = revolution_s;
    out.notes = std::move(notes_);
    out.runs = std::move(runs_);
    return out;
  }

 private:
  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const {
    throw_input_error(file_, where_ + ": " + field, found, allowed);
  }

  void read(const std::vector<std::vector<CloudPoint>>& sweeps, const std::vector<int>& row_of) {
    const Lidar& table = requested_.table;
    const std::vector<double> tolerances = row_tolerances(table);
    for (const auto& sweep : sweeps) {
      std::vector<FiredRun> rows(table.rows.size());
      std::vector<Fired> all;
      double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s;
      for (const CloudPoint& point : sweep) {
        const int row = row_of.empty() ? nearest_row(table, tolerances, point.position)
                                       : row_of[static_cast<std::size_t>(point.ring)];
        const auto hit = row < 0 ? std::nullopt : locate_in_row(table, row, point.position);
        if (!hit) continue;
        const LidarRow& beam = table.rows[static_cast<std::size_t>(row)];
        rows[static_cast<std::size_t>(row)].push_back(hit->azimuth);
        if (std::isnan(point.time_s)) continue;
        all.push_back({(hit->azimuth - beam.azimuth_offset) / kTurn, point.time_s - beam.time_offset});
        first_s = std::min(first_s, point.time_s);
        last_s = std::max(last_s, point.time_s);
      }
      longest_s_ = std::max(longest_s_, last_s - first_s);
      constexpr std::size_t kSamples = 1024;  // per sweep
      const std::size_t step = all.size() / kSamples + 1;
      fired_.emplace_back();
      for (std::size_t i = 0; i < all.size(); i += step) fired_.back().push_back(all[i]);
      for (FiredRun& row : rows) runs_.push_back(std::move(row));
    }
  }

  /// Returns how well a revolution of that duration explains the points' times, for the better direction, from
  /// 0 to 1. Each sweep separately, because stamps need not be a revolution apart.
  [[nodiscard]] double coherence(double revolution_s) const {
    double best = 0.0;
    for (const double side : {1.0, -1.0}) {
      double sum = 0.0, count = 0.0;
      for (const auto& sweep : fired_) {
        std::complex<double> phases;
        for (const Fired& f : sweep)
          phases += std::polar(1.0, kTurn * (f.time_s / revolution_s - side * f.turned));
        sum += std::abs(phases);
        count += static_cast<double>(sweep.size());
      }
      best = std::max(best, count > 0.0 ? sum / count : 0.0);
    }
    return best;
  }

  /// Returns the duration that explains the times best.
  [[nodiscard]] double best_turn() const {
    constexpr double kStep = 0.02, kFastest = 1.5;  // revolutions within the longest sweep
    double best = kStep, most = 0.0;
    for (double rate = kStep; rate <= kFastest; rate += kStep) {
      const double value = coherence(longest_s_ / rate);
      if (value <= most) continue;
      most = value;
      best = rate;
    }
    constexpr double kGolden = 0.6180339887;
    double low = std::max(0.1 * kStep, best - kStep), high = best + kStep;
    for (int i = 0; i < 30; ++i) {
      const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
      (coherence(longest_s_ / a) < coherence(longest_s_ / b) ? low : high) =
          coherence(longest_s_ / a) < coherence(longest_s_ / b) ? a : b;
    }
    return longest_s_ / (0.5 * (low + high));
  }

  double by_times() const {
    if (!(longest_s_ > 0.0)) return apart_s_ > 0.0 ? apart_s_ : requested_.table.sweep_s;
    const double free_s = best_turn(), best = coherence(free_s);
    constexpr double kLeastCoherent = 0.9;
    if (best < kLeastCoherent) {
      refuse("points' times",
             "such that fit no turn",
             fmt::format("one turn in {:.4f} s, or a part of it: {}",
                         apart_s_ > 0.0 ? apart_s_ : requested_.table.sweep_s,
                         kUnit));
    }
    constexpr double kNoise = 2e-3;  // of a full revolution; 3 % of its duration
    const double worst = std::max(kNoise, 3.0 * (1.0 - best));
    const auto fits = [&](double revolution_s) {
      return revolution_s >= kShortest_s && longest_s_ <= 1.5 * revolution_s &&
             1.0 - coherence(revolution_s) <= worst;
    };
    std::vector<double> tried;
    if (apart_s_ > 0.0) {
      tried.push_back(apart_s_);
      for (const LidarMode& mode : modes_) {
        const double lost = std::max(1.0, std::round(apart_s_ * mode.spin_hz));
        if (is_near(apart_s_ / lost, 1.0 / mode.spin_hz, kSameTurn)) tried.push_back(apart_s_ / lost);
      }
      for (double lost = 2.0; apart_s_ / lost >= kShortest_s; ++lost) tried.push_back(apart_s_ / lost);
    } else {
      tried.push_back(requested_.table.sweep_s);
    }
    for (const LidarMode& mode : modes_) tried.push_back(1.0 / mode.spin_hz);
    tried.push_back(free_s);
    const auto first = std::find_if(tried.begin(), tried.end(), fits);
    if (first == tried.end()) {
      refuse("points' times",
             fmt::format("such that fit no turn but one in {:.3g} s", free_s),
             fmt::format("{} to {} s: {}", kShortest_s, kLongestSweep_s, kUnit));
    }
    return *first;
  }

  /// Without times: returns the mode that agrees with the points' steps and the messages and loses the fewest.
  double by_modes(double steps) const {
    std::vector<LidarMode> allowed;
    const auto keep = [&](auto is_so) {
      if (allowed.empty()) std::copy_if(modes_.begin(), modes_.end(), std::back_inserter(allowed), is_so);
    };
    if (steps > 0.0) {
      keep([&](const LidarMode& m) { return is_near(steps, m.columns, kSameColumns); });
      // In evenly thinned clouds only some modes' columns continue through the revolution.
      constexpr double kOnGrid = 0.9;
      keep([&](const LidarMode& m) {
        return fit_of_step(runs_, requested_.table.azimuth_span / m.columns) > kOnGrid;
      });
    }
    keep([](const LidarMode&) { return true; });
    if (!(apart_s_ > 0.0)) return 1.0 / allowed.front().spin_hz;
    double fewest = std::numeric_limits<double>::infinity(), revolution_s = apart_s_;
    for (const LidarMode& mode : allowed) {
      const double lost = std::max(1.0, std::round(apart_s_ * mode.spin_hz));
      if (lost >= fewest || !is_near(apart_s_ / lost, 1.0 / mode.spin_hz, lost > 1.0 ? kSameTurn : kSameRate))
        continue;
      fewest = lost;
      revolution_s = apart_s_ / lost;
    }
    return revolution_s;
  }

  void print_lost(double revolution_s) {
    if (!(apart_s_ > 0.0) || is_near(apart_s_, revolution_s, kSameTurn)) return;
    const double turns = apart_s_ / revolution_s, whole = std::round(turns);
    notes_.push_back(
        is_near(turns, whole, kSameTurn)
            ? fmt::format("a cloud of every {:.0f} turns", whole)
            : fmt::format("a turn in {:.4g} s, though clouds are {:.4g} s apart", revolution_s, apart_s_));
  }

  LidarMode mode_of(double revolution_s, double steps) {
    const double hz = 1.0 / revolution_s;
    std::vector<LidarMode> at_rate;
    std::copy_if(modes_.begin(), modes_.end(), std::back_inserter(at_rate), [&](const LidarMode& m) {
      return is_near(1.0 / m.spin_hz, revolution_s, kSameRate);
    });
    const bool was_listed = !at_rate.empty();
    if (!was_listed && requested_.is_mode_given) {
      std::string rates;
      for (const LidarMode& mode : modes_)
        rates += fmt::format("{}{:.4g}", rates.empty() ? "" : ", ", 1.0 / mode.spin_hz);
      refuse(
          "turn",
          fmt::format("{:.4g} s", revolution_s),
          fmt::format("{} s, as {} has: without a mode the import finds it", rates, requested_.table.name));
    }
    if (!was_listed) {  // equal firing rate, if all modes have the same
      const double rate = modes_.front().spin_hz * modes_.front().columns;
      const bool is_steady =
          modes_.size() > 1 && std::all_of(modes_.begin(), modes_.end(), [&](const auto& m) {
            return is_near(m.spin_hz * m.columns, rate, kSameTurn);
          });
      const double columns = is_steady ? rate / hz : requested_.table.columns;
      at_rate = {{hz, std::max(1, static_cast<int>(std::lround(columns)))}};
    }
    if (!(steps > 0.0)) return {hz, at_rate.front().columns};
    for (const LidarMode& mode : at_rate) {
      if (is_near(steps, mode.columns, kSameColumns)) return {hz, mode.columns};
    }
    if (requested_.is_mode_given && steps * kThinned > at_rate.front().columns) {
      refuse("columns",
             fmt::format("points {:.4g} a turn apart", std::round(steps)),
             fmt::format("{}, as {} has: without a mode the import finds it",
                         at_rate.front().columns,
                         requested_.table.name));
    }
    if (steps * kThinned < at_rate.front().columns || steps > kThinned * at_rate.front().columns) {
      notes_.push_back(fmt::format(
          "points have {:.0f} columns per revolution, the table {}: thinned clouds, whose other rays count "
          "as such that returned nothing",
          steps,
          at_rate.front().columns));
      return {hz, at_rate.front().columns};
    }
    return {hz, static_cast<int>(std::lround(steps))};
  }

  const Ros2Lidar& requested_;
  double apart_s_;
  const std::string& file_;
  const std::string& where_;
  std::vector<LidarMode> modes_;
  std::vector<FiredRun> runs_;             // by sweep and beam
  std::vector<std::vector<Fired>> fired_;  // by sweep, with times
  double longest_s_ = 0.0;                 // between the first and last time of a sweep
  std::vector<std::string> notes_;
};

}  // namespace

RecordedRevolution find_turn(const Ros2Lidar& requested,
                             const std::vector<std::vector<CloudPoint>>& sweeps,
                             const std::vector<int>& row_of,
                             double apart_s,
                             const std::string& file,
                             const std::string& where) {
  return RevolutionFinder(requested, apart_s, file, where).found(sweeps, row_of);
}

}  // namespace simuli::ros2
