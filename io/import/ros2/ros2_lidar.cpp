#include "io/import/ros2/ros2_lidar.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/spread.hpp"
#include "host/core/sensors/lidar.hpp"
#include "host/core/sensors/lidar_locate.hpp"
#include "io/import/points/point_grid.hpp"
#include "io/import/points/unit_offset.hpp"
#include "io/import/ros2/ros2_revolution.hpp"

namespace simuli::ros2 {
namespace {

constexpr std::size_t kSamplesOfRing = 48;

using Rings = std::map<int, std::vector<const CloudPoint*>>;

/// Returns up to kSamplesOfRing points of each ring, from all azimuths.
Rings sampled(const std::vector<std::vector<CloudPoint>>& sweeps) {
  Rings all, some;
  for (const auto& sweep : sweeps) {
    for (const CloudPoint& point : sweep) all[point.ring].push_back(&point);
  }
  for (const auto& [ring, points] : all) {
    const std::size_t count = std::min(points.size(), kSamplesOfRing);
    for (std::size_t i = 0; i < count; ++i) some[ring].push_back(points[i * points.size() / count]);
  }
  return some;
}

/// Returns the median elevation of the points above a beam, rad; no value if it sees none of them.
std::optional<double> off_row(const Lidar& lidar, int row, const std::vector<const CloudPoint*>& points) {
  std::vector<double> off;
  for (const CloudPoint* point : points) {
    const auto hit = locate_in_row(lidar, row, point->position);
    if (hit) off.push_back(std::abs(hit->elevation_error));
  }
  if (off.empty()) return {};
  return upper_median(std::move(off));
}

struct NearestTable {
  std::string text = "none";
  bool is_whole = false;  // every beam has a ring within the tolerance between units
};

/// Returns the built-in table whose beams are nearest to the rings. A ring on another ring's beam and a beam
/// without a ring count as errors of a degree.
NearestTable nearest_table(const Rings& rings) {
  constexpr double kAlike = 0.1 * kDegree;
  NearestTable nearest;
  double least = std::numeric_limits<double>::infinity();
  for (const std::string& name : builtin_lidar_names()) {
    const Lidar table = builtin_lidar(name);
    const int rows = table.row_count();
    if (rows < static_cast<int>(rings.size())) continue;
    std::set<int> taken;
    double sum = 0.0;
    for (const auto& [ring, points] : rings) {
      const std::vector<const CloudPoint*> some(
          points.begin(), points.begin() + std::min<std::ptrdiff_t>(8, std::ssize(points)));
      double off = kDegree;
      int best = -1;
      for (int row = 0; row < rows; ++row) {
        const double own = off_row(table, row, some).value_or(kDegree);
        if (own < off) best = row;
        off = std::min(off, own);
      }
      sum += off;
      taken.insert(best);
    }
    const double mean = sum / static_cast<double>(rings.size());
    const double cost =
        mean + kDegree * (1.0 - static_cast<double>(taken.size()) / static_cast<double>(rows));
    if (cost >= least) continue;
    least = cost;
    nearest = {
        fmt::format(
            "{} ({:.3f} degrees off in the mean, {} of {} rows)", name, mean / kDegree, taken.size(), rows),
        static_cast<int>(taken.size()) == rows && mean < kAlike};
  }
  return nearest;
}

class Fit {
 public:
  Fit(const Lidar& table, const std::string& file, const std::string& where) : file_(file), where_(where) {
    out.model = table;
  }

  void rows(const Rings& rings) {
    const int count = out.model.row_count();
    const std::vector<double> tolerances = row_tolerances(out.model);
    const int last = rings.rbegin()->first;
    if (last >= count) {
      refuse("rings", fmt::format("{}", last), fmt::format("0 to {}: rows of {}", count - 1, out.model.name));
    }
    out.row_of.assign(static_cast<std::size_t>(count), -1);
    std::map<int, int> ring_of;
    for (const auto& [ring, points] : rings) {
      int best = -1;
      double least = 0.0;
      for (int row = 0; row < count; ++row) {
        const auto off = off_row(out.model, row, points);
        if (off && (best < 0 || *off < least)) {
          best = row;
          least = *off;
        }
      }
      if (best < 0 || least > tolerances[static_cast<std::size_t>(best)]) {
        refuse(fmt::format("ring {}", ring),
               best < 0 ? "on no row" : fmt::format("{:.2f} degrees from the nearest beam", least / kDegree),
               fmt::format("on a row of {}: {}", out.model.name, doubt(rings)));
      }
      const auto [other, is_new] = ring_of.emplace(best, ring);
      if (!is_new) {
        refuse(fmt::format("rings {} and {}", other->second, ring),
               fmt::format("both on row {}", best),
               fmt::format("a row of {} each: {}", out.model.name, doubt(rings)));
      }
      out.row_of[static_cast<std::size_t>(ring)] = best;
    }
    need_own_rows(rings, last + 1 == static_cast<int>(rings.size()));
    complete(ring_of.size());
  }

  /// For points without rings.
  void rows(const std::vector<Eigen::Vector3d>& places) {
    const std::vector<double> tolerances = row_tolerances(out.model);
    std::vector<CloudPoint> points(places.size());
    Rings by_row;
    for (std::size_t i = 0; i < places.size(); ++i) {
      points[i].position = places[i];
      const int row = nearest_row(out.model, tolerances, places[i]);
      if (row >= 0) by_row[row].push_back(&points[i]);
    }
    need_own_rows(by_row, true);
  }

  /// Finds the azimuth and direction at which a revolution begins, from the points' times.
  void turn(const Rings& rings) {
    Lidar& model = out.model;
    // an oscillating LiDAR: the table determines the direction
    if (std::abs(model.azimuth_span - kTurn) > 1e-6) return;
    const double period_s = model.sweep_s;
    std::optional<std::complex<double>> best;
    SpinDirection side = model.spin;
    for (const SpinDirection spin : {model.spin, other(model.spin)}) {
      Lidar tried = model;
      tried.spin = spin;
      const std::complex<double> sum = mean_phase(tried, rings, period_s);
      if (best && std::abs(sum) <= std::abs(*best)) continue;
      best = sum;
      side = spin;
    }
    constexpr double kLeastCoherent = 0.9;
    if (std::abs(*best) < kLeastCoherent) {
      refuse("points' times",
             "such that fit no turn",
             fmt::format("one revolution in {:.4f} s, or --point-time for another unit", period_s));
    }
    if (side != model.spin) {
      model.spin = side;
      out.notes.push_back(side == SpinDirection::kClockwise
                              ? "turns clockwise, by the points' times"
                              : "turns counter-clockwise, by the points' times");
    }
    // share of a revolution by which points are later than in the table
    const double share = std::arg(*best) / kTurn;
    if (std::abs(share) <= 0.5 / model.columns) return;
    model.azimuth_first = std::remainder(model.azimuth_first - model.spin_sign() * share * kTurn, kTurn);
    out.notes.push_back(fmt::format("the first column is at {:.2f} degrees, by the points' times",
                                    model.azimuth_first / kDegree));
  }

  void start(const std::vector<std::vector<CloudPoint>>& sweeps, Stamp stamp) {
    const double period_s = out.model.sweep_s;
    double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s;
    for (const auto& sweep : sweeps) {
      for (const CloudPoint& point : sweep) {
        first_s = std::min(first_s, point.time_s);
        last_s = std::max(last_s, point.time_s);
      }
    }
    const bool has_times = std::isfinite(first_s);
    if (has_times && last_s - first_s > 1.5 * period_s) {
      refuse("points' times",
             fmt::format("{:.4f} s from first to last", last_s - first_s),
             fmt::format("a revolution's {:.4f} s, or --point-time FIELD:UNIT for another unit", period_s));
    }
    if (!has_times && stamp == Stamp::kUnknown)
      refuse("points' times", "none", "some, or --stamp start or end: which of the sweep a stamp is");
    const double slack_s = 0.1 * period_s;
    if (stamp == Stamp::kUnknown) {
      const bool is_start = first_s >= -slack_s, is_end = last_s <= slack_s;
      if (!is_start && !is_end) {
        out.start_after_stamp_s = first_s;
        out.notes.push_back(
            fmt::format("sweeps begin {:.4f} s after their stamp, by the points' times", first_s));
        return;
      }
      stamp = is_start ? Stamp::kStart : Stamp::kEnd;
    }
    out.start_after_stamp_s = stamp == Stamp::kStart ? 0.0 : -period_s;
    out.notes.emplace_back(stamp == Stamp::kStart ? "stamped at the start of a sweep"
                                                  : "stamped at the end of a sweep");
  }

  [[noreturn]] void refuse(const std::string& field,
                           const std::string& found,
                           const std::string& allowed) const {
    throw_input_error(file_, where_ + ": " + field, found, allowed);
  }

  RecordedLidar out;

 private:
  /// Notes beams without returns; or refuses a table of another sensor if its beams would all be without
  /// returns, because they would be learned as beams that never return.
  void need_own_rows(const Rings& rings, bool are_all) {
    const auto known = static_cast<int>(rings.size()), count = out.model.row_count();
    if (known == 0 || known == count) return;
    if (are_all && nearest_table(rings).is_whole) {
      refuse("rows",
             fmt::format("points on {} of {}", known, count),
             fmt::format("on all of {}: {}", out.model.name, doubt(rings)));
    }
    out.notes.push_back(
        fmt::format("{} of {} rows return nothing in the first sweeps", count - known, count));
  }

  [[nodiscard]] std::string doubt(const Rings& rings) const {
    return fmt::format(
        "is it that sensor, in that frame (of Ouster often --lidar TOPIC=SENSOR:os_sensor)? Nearest built-in "
        "table: "
        "{}; its own: simuli fit beams {} --topic {} -o FILE, for --lidar {}=FILE",
        nearest_table(rings).text,
        file_,
        where_,
        where_);
  }

  static SpinDirection other(SpinDirection spin) {
    return spin == SpinDirection::kClockwise ? SpinDirection::kCounterClockwise : SpinDirection::kClockwise;
  }

  /// Rings without points in the samples continue the order of the others, if that is regular.
  void complete(std::size_t known) {
    const auto count = static_cast<int>(out.row_of.size());
    const auto follows = [&](bool is_reversed) {
      for (int ring = 0; ring < count; ++ring) {
        const int row = out.row_of[static_cast<std::size_t>(ring)];
        if (row >= 0 && row != (is_reversed ? count - 1 - ring : ring)) return false;
      }
      return true;
    };
    const bool is_straight = follows(false), is_reversed = follows(true);
    if (is_straight != is_reversed) {
      for (int ring = 0; ring < count; ++ring)
        out.row_of[static_cast<std::size_t>(ring)] = is_reversed ? count - 1 - ring : ring;
      out.notes.emplace_back(is_reversed ? "ring 0 is the lowest beam" : "ring 0 is the highest beam");
    } else {
      out.notes.push_back(fmt::format("{} rings, each on the beam that its points lie on", known));
    }
  }

  /// Returns the mean over the points of exp(i 2 pi (time minus the table's time, in revolutions)).
  [[nodiscard]] std::complex<double> mean_phase(const Lidar& tried,
                                                const Rings& rings,
                                                double period_s) const {
    std::complex<double> sum;
    double count = 0.0;
    for (const auto& [ring, points] : rings) {
      for (const CloudPoint* point : points) {
        const auto hit =
            ring < 0 ? locate(tried, point->position)
                     : locate_in_row(tried, out.row_of[static_cast<std::size_t>(ring)], point->position);
        if (!hit || std::isnan(point->time_s)) continue;
        sum += std::polar(
            1.0,
            kTurn * (point->time_s / period_s - hit->time_fraction - out.start_after_stamp_s / period_s));
        count += 1.0;
      }
    }
    return count > 0.0 ? sum / count : std::complex<double>(1.0);
  }

  const std::string& file_;
  const std::string& where_;
};

}  // namespace

RecordedLidar fit_recorded(const Ros2Lidar& as_asked,
                           const std::vector<std::vector<CloudPoint>>& sweeps,
                           double apart_s,
                           Stamp stamp,
                           const std::string& file,
                           const std::string& where) {
  Ros2Lidar requested = as_asked;
  const Rings rings = sampled(sweeps);
  std::vector<Eigen::Vector3d> places;
  for (const auto& sweep : sweeps) {
    for (const CloudPoint& point : sweep) places.push_back(point.position);
  }
  const double offset = unit_offset(requested.table, places);
  std::vector<std::string> notes;
  if (offset != 0.0) notes.push_back(raise_beams(requested.table, offset));
  Fit fit(requested.table, file, where);
  fit.out.notes = std::move(notes);
  if (rings.empty()) fit.refuse("points", "none in the first sweeps", "some");
  const bool has_rings = rings.begin()->first >= 0;
  if (!has_rings && rings.size() > 1) fit.refuse("rings", "of some points", "those of all, or of none");
  if (has_rings)
    fit.rows(rings);
  else
    fit.rows(places);
  RecordedRevolution turn = find_turn(requested, sweeps, fit.out.row_of, apart_s, file, where);
  fit.out.model = std::move(turn.model);
  std::move(turn.notes.begin(), turn.notes.end(), std::back_inserter(fit.out.notes));
  fit.start(sweeps, stamp);
  if (!std::isnan(rings.begin()->second.front()->time_s)) fit.turn(rings);
  const int changed = set_firing_pattern(turn.runs, fit.out.model);
  if (changed > 0)
    fit.out.notes.push_back(fmt::format("{} beams fire in other columns than in the table", changed));
  return fit.out;
}

std::vector<MeasuredPoint> measured(const std::vector<CloudPoint>& points,
                                    const RecordedLidar& lidar,
                                    const std::string& file,
                                    const std::string& where) {
  std::vector<MeasuredPoint> out;
  out.reserve(points.size());
  for (const CloudPoint& point : points) {
    MeasuredPoint m;
    m.position = lidar.table_from_cloud * point.position;
    m.intensity = point.intensity;
    if (!lidar.row_of.empty()) {
      const auto ring = static_cast<std::size_t>(point.ring);
      if (ring >= lidar.row_of.size() || lidar.row_of[ring] < 0) {
        throw_input_error(file,
                          where + ": ring",
                          fmt::format("{}", point.ring),
                          fmt::format("one of the first sweeps', below {}", lidar.row_of.size()));
      }
      m.row = lidar.row_of[ring];
    }
    m.time_fraction = (point.time_s - lidar.start_after_stamp_s) / lidar.model.sweep_s;  // NaN without times
    if (m.time_fraction < -0.5 || m.time_fraction > 1.5) {
      throw_input_error(
          file,
          where + ": a point's time",
          fmt::format("{:.4f} s after the stamp", point.time_s),
          fmt::format("within its sweep of {:.4f} s, or half a sweep outside", lidar.model.sweep_s));
    }
    out.push_back(m);
  }
  return out;
}

}  // namespace simuli::ros2
