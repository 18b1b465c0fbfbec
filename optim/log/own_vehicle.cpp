#include "optim/log/own_vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <variant>

#include "io/log/frame_files.hpp"
#include "optim/base/frames.hpp"

namespace simuli {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kBelowHorizon_rad = 5.0 * std::numbers::pi / 180.0;
constexpr std::size_t kFewestSweepsOfADrive = 8;
constexpr double kShortestDrive_m = 5.0;  // behind which a parked car is seen elsewhere
constexpr std::size_t kFewestRays = 5;    // in a cell, before it is called blind
constexpr std::size_t kFewestCells = 3;   // in an arc: a single cell may be chance

struct Cell {
  std::uint32_t rays = 0;
  std::uint32_t returns = 0;
};

/// Blind cells of a row as arcs. A cell that hardly a ray has passed is as blind as both of its neighbours.
void append_arcs(const Cell* cells, std::size_t count, int row, std::vector<BlindArc>& arcs) {
  const auto is_open = [&](std::size_t i) { return cells[i].returns > 0; };
  const auto is_sure = [&](std::size_t i) { return !is_open(i) && cells[i].rays >= kFewestRays; };
  const double step = kTurn_rad / static_cast<double>(count);
  for (std::size_t begin = 0; begin < count;) {
    if (!is_sure(begin)) {
      ++begin;
      continue;
    }
    std::size_t end = begin + 1;  // behind the last sure cell
    for (std::size_t i = end; i < count && !is_open(i); ++i) {
      if (is_sure(i)) end = i + 1;
    }
    if (end - begin >= kFewestCells) {
      arcs.push_back({row, static_cast<double>(begin) * step, static_cast<double>(end) * step});
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
    if (!std::holds_alternative<Lidar>(mounted.model)) continue;  // arcs are of rows
    const auto& lidar = std::get<Lidar>(mounted.model);
    std::vector<const SweepFrame*> sweeps;
    for (const std::size_t index : training) {
      if (log.sweeps[index].lidar == lidar.name) sweeps.push_back(&log.sweeps[index]);
    }
    if (sweeps.size() < kFewestSweepsOfADrive) continue;
    const auto rig_at = [&](const SweepFrame& f) {
      return log.world_from_rig.at(f.time_start_s).translation;
    };
    if ((rig_at(*sweeps.back()) - rig_at(*sweeps.front())).norm() < kShortestDrive_m) continue;

    const auto per_row =
        static_cast<std::size_t>(std::lround(lidar.columns * kTurn_rad / lidar.azimuth_span));
    std::vector<Cell> cells(lidar.rows.size() * per_row);
    expect(log, sweeps);
    for (const SweepFrame* frame : sweeps) {
      const Sweep sweep = read_sweep(log, *frame, lidar);
      for (std::size_t i = 0; i < sweep.range.size(); ++i) {
        const std::size_t row = i / static_cast<std::size_t>(lidar.columns);
        if (lidar.rows[row].elevation > -kBelowHorizon_rad) continue;
        const double turns = static_cast<double>(sweep.rays.azimuth[i]) / kTurn_rad;
        const auto cell =
            static_cast<std::size_t>((turns - std::floor(turns)) * static_cast<double>(per_row));
        Cell& c = cells[row * per_row + std::min(cell, per_row - 1)];
        ++c.rays;
        if (sweep.range[i] > 0.0F) ++c.returns;
      }
    }
    for (std::size_t row = 0; row < lidar.rows.size(); ++row) {
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
