#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <variant>

#include "host/core/base/spread.hpp"
#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"
#include "optim/data/sensor_learning.hpp"

namespace simuli {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kBelowHorizon_rad = 5.0 * std::numbers::pi / 180.0;
constexpr std::size_t kFewestSweepsOfADrive = 8;
constexpr double kShortestDrive_m =
    5.0;                                // shortest path after which surroundings of a parked car have changed
constexpr std::size_t kFewestRays = 5;  // in a cell, to call it blind
constexpr std::size_t kFewestCells = 3;  // in an arc, because single cells may be chance
// Thresholds for returns of the ego vehicle. PandaSet's from its roof scatter by 1 to 4 cm between sweeps.
constexpr double kOwnRange_m = 3.0;
constexpr double kOwnScatter_m = 0.1;        // standard deviation
constexpr double kOwnDrop = 0.5;             // largest height below the sensor relative to the ground's
constexpr double kOwnHalfWidth_m = 1.25;     // excludes a wall at a constant distance next to the path
constexpr double kOwnShortestDrive_m = 1.0;  // static surroundings come nearer by as much
constexpr double kOwnShare = 0.2;            // of a cell's rays: at edges of the roof some rays pass it

struct Cell {
  std::uint32_t rays = 0;
  std::uint32_t returns = 0;
  std::uint32_t near = 0;  // returns nearer than kOwnRange_m
  double near_sum_m = 0.0, near_squares_m2 = 0.0;
  bool own = false;  // its returns are the ego vehicle's

  /// Whether the cell's near returns belong to the ego vehicle. `in_rig`: direction of the cell in the rig, for
  /// a sensor at `origin_m`; `ground_m`: depth of the ground below the sensor.
  [[nodiscard]] bool is_own(const Eigen::Vector3d& in_rig,
                            const Eigen::Vector3d& origin_m,
                            double ground_m) const {
    if (near < kFewestRays || near < kOwnShare * rays) return false;
    const double mean_m = near_sum_m / near;
    const double variance_m2 = near_squares_m2 / near - mean_m * mean_m;
    return variance_m2 < kOwnScatter_m * kOwnScatter_m && -mean_m * in_rig.z() < kOwnDrop * ground_m &&
           std::abs(origin_m.y() + mean_m * in_rig.y()) < kOwnHalfWidth_m;
  }
};

/// Appends the blind cells of a row as arcs. Cells with hardly any ray are blind if both neighbours are.
void append_arcs(const Cell* cells, std::size_t count, int row, std::vector<BlindArc>& arcs) {
  const auto is_open = [&](std::size_t i) { return cells[i].returns > 0 && !cells[i].own; };
  const auto is_sure = [&](std::size_t i) { return !is_open(i) && cells[i].rays >= kFewestRays; };
  const double step = kTurn_rad / static_cast<double>(count);
  for (std::size_t begin = 0; begin < count;) {
    if (!is_sure(begin)) {
      ++begin;
      continue;
    }
    std::size_t end = begin + 1;  // after the last certain cell
    for (std::size_t i = end; i < count && !is_open(i); ++i) {
      if (is_sure(i)) end = i + 1;
    }
    if (end - begin >= kFewestCells) {
      const bool own = std::any_of(cells + begin, cells + end, [](const Cell& c) { return c.own; });
      arcs.push_back({row, static_cast<double>(begin) * step, static_cast<double>(end) * step, own});
    }
    begin = end;
  }
}

}  // namespace

std::vector<std::vector<BlindArc>> find_blind_arcs(const Log& log, const FrameSelection& frames) {
  std::vector<std::vector<BlindArc>> found;
  const std::vector<std::size_t> training = HeldOutRule(log, frames).training(log.sweeps);
  for (const LogLidar& mounted : log.lidars) {
    found.emplace_back();
    if (!std::holds_alternative<Lidar>(mounted.model)) continue;  // arcs belong to rows
    auto lidar = std::get<Lidar>(mounted.model);
    lidar.blind.clear();  // otherwise returns from known arcs would be ignored
    std::vector<const SweepFrame*> sweeps;
    for (const std::size_t index : training) {
      if (log.sweeps[index].lidar == lidar.name) sweeps.push_back(&log.sweeps[index]);
    }
    if (sweeps.size() < kFewestSweepsOfADrive) continue;
    const auto rig_at = [&](const SweepFrame& f) {
      return log.world_from_rig.at(f.time_start_s).translation;
    };
    const double driven_m = (rig_at(*sweeps.back()) - rig_at(*sweeps.front())).norm();
    if (driven_m < kOwnShortestDrive_m) continue;

    const auto per_row =
        static_cast<std::size_t>(std::lround(lidar.columns * kTurn_rad / lidar.azimuth_span));
    std::vector<Cell> cells(lidar.rows.size() * per_row);
    std::vector<double> grounds_m;  // of the ground below the sensor, by sweep
    expect(log, sweeps);
    for (const SweepFrame* frame : sweeps) {
      const Sweep sweep = read_sweep(log, *frame, lidar);
      std::vector<double> drops_m;  // of returns beyond the ego vehicle's
      for (std::size_t i = 0; i < sweep.range.size(); ++i) {
        const std::size_t row = i / static_cast<std::size_t>(lidar.columns);
        if (lidar.rows[row].elevation > -kBelowHorizon_rad) continue;
        const double turns = static_cast<double>(sweep.rays.azimuth[i]) / kTurn_rad;
        const auto cell =
            static_cast<std::size_t>((turns - std::floor(turns)) * static_cast<double>(per_row));
        Cell& c = cells[row * per_row + std::min(cell, per_row - 1)];
        ++c.rays;
        const auto range_m = static_cast<double>(sweep.range[i]);
        if (!(range_m > 0.0)) continue;
        ++c.returns;
        if (range_m < kOwnRange_m) {
          ++c.near;
          c.near_sum_m += range_m;
          c.near_squares_m2 += range_m * range_m;
        } else {
          drops_m.push_back(range_m * std::sin(-lidar.rows[row].elevation));
        }
      }
      if (!drops_m.empty()) grounds_m.push_back(upper_median(std::move(drops_m)));
    }
    const double ground_m = upper_median(std::move(grounds_m));
    const Pose& rig_from_lidar = mounted.rig_from_lidar;
    for (std::size_t row = 0; row < lidar.rows.size(); ++row) {
      for (std::size_t i = 0; i < per_row; ++i) {
        Cell& c = cells[row * per_row + i];
        const double azimuth = (static_cast<double>(i) + 0.5) * kTurn_rad / static_cast<double>(per_row);
        const Eigen::Vector3d in_rig =
            rig_from_lidar.rotation * Lidar::direction(azimuth, lidar.rows[row].elevation);
        c.own = c.is_own(in_rig, rig_from_lidar.translation, ground_m);
        if (!c.own && driven_m < kShortestDrive_m)
          c.rays = 0;  // missing returns may be due to the surroundings
      }
      append_arcs(&cells[row * per_row], per_row, static_cast<int>(row), found.back());
    }
  }
  return found;
}

Log with_blind_arcs(Log log, const FrameSelection& frames) {
  const auto found = find_blind_arcs(log, frames);
  for (std::size_t i = 0; i < log.lidars.size(); ++i) {
    auto* const lidar = std::get_if<Lidar>(&log.lidars[i].model);
    if (lidar != nullptr && lidar->blind.empty()) lidar->blind = found[i];
  }
  return log;
}

}  // namespace simuli
