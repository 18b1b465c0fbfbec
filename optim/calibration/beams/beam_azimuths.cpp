#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <fmt/format.h>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>

#include "host/core/base/angles.hpp"
#include "host/core/base/spread.hpp"
#include "optim/calibration/beams/beam_parts.hpp"

namespace simuli::calibration {
namespace {

using Complex = std::complex<double>;
using SweepsOfRow = std::vector<std::vector<BeamPoint>>;

constexpr double kWidest_m = 0.08;  // horizontal offset, either side
constexpr double kStep_m = 2e-3;
constexpr double kCoherent =
    0.7;  // mean of exp(i ticks azimuth): 1 for azimuths on a grid, 0 for random ones
/// Smallest difference between the best and the worst offset: at equal ranges all offsets fit alike.
constexpr double kContrast = 0.05;

/// Azimuth of the beam through p that passes the axis `side` m to the left.
double beam_azimuth(const BeamPoint& p, double side) {
  return p.azimuth - std::asin(std::clamp(side / p.distance, -1.0, 1.0));
}

/// Mean of exp(i ticks azimuth) over a row's points.
Complex grid_phasor(const SweepsOfRow& sweeps, int ticks, double side) {
  constexpr std::size_t kMost = 8000;
  std::size_t count = 0;
  for (const auto& sweep : sweeps) count += sweep.size();
  const std::size_t stride = std::max<std::size_t>(1, count / kMost);
  Complex sum = 0.0;
  std::size_t number = 0;
  std::size_t used = 0;
  for (const auto& sweep : sweeps) {
    for (const BeamPoint& p : sweep) {
      if (number++ % stride != 0) continue;
      sum += std::polar(1.0, ticks * beam_azimuth(p, side));
      ++used;
    }
  }
  return used > 0 ? sum / static_cast<double>(used) : Complex{};
}

/// Encoder ticks per revolution of the azimuths of the fullest rows; 0 without a grid.
int find_ticks(const BeamPoints& points, const std::vector<std::size_t>& fullest) {
  constexpr int kFewest = 300;
  constexpr int kMost = 8000;
  constexpr int kBins = 1 << 15;
  Eigen::FFT<double> fft;
  std::vector<double> strongest(kMost + 1, 0.0);
  for (std::size_t i = 0; i < std::min<std::size_t>(4, fullest.size()); ++i) {
    const SweepsOfRow& sweeps = points[fullest[i]];
    const auto sweep = std::max_element(
        sweeps.begin(), sweeps.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    if (sweep->size() < 100) continue;
    for (double side = -kWidest_m; side <= kWidest_m; side += kStep_m) {
      std::vector<double> histogram(kBins, 0.0);
      for (const BeamPoint& p : *sweep) {
        const double turn = beam_azimuth(p, side) / kTurn;
        const auto bin = static_cast<std::size_t>((turn - std::floor(turn)) * kBins);
        histogram[std::min<std::size_t>(bin, kBins - 1)] += 1.0 / static_cast<double>(sweep->size());
      }
      std::vector<Complex> spectrum;
      fft.fwd(spectrum, histogram);
      for (int n = kFewest; n <= kMost; ++n) {
        // Binning attenuates the highest frequencies.
        const double blur = std::numbers::pi * n / kBins;
        const auto place = static_cast<std::size_t>(n);
        strongest[place] = std::max(strongest[place], std::abs(spectrum[place]) * blur / std::sin(blur));
      }
    }
  }
  const auto best = std::max_element(strongest.begin(), strongest.end());
  if (!(*best >= kCoherent)) return 0;
  // A grid of n ticks is also one of 2 n, 3 n, ...
  const auto first =
      std::find_if(strongest.begin(), strongest.end(), [&](double v) { return v >= 0.95 * *best; });
  return static_cast<int>(first - strongest.begin());
}

/// Finds the offset that puts the row's azimuths on the grid; false when none does, or all do.
bool find_side(const SweepsOfRow& sweeps, int ticks, double& side) {
  double best = -1.0;
  double worst = 2.0;
  for (double h = -kWidest_m; h <= kWidest_m + 1e-9; h += kStep_m) {
    const double coherence = std::abs(grid_phasor(sweeps, ticks, h));
    if (coherence > best) side = h;
    best = std::max(best, coherence);
    worst = std::min(worst, coherence);
  }
  if (!(best >= kCoherent && best - worst >= kContrast)) return false;
  const double below = std::abs(grid_phasor(sweeps, ticks, side - kStep_m));
  const double above = std::abs(grid_phasor(sweeps, ticks, side + kStep_m));
  const double bend = below - 2.0 * best + above;
  if (bend < 0.0) side += std::clamp(0.5 * (below - above) / bend, -1.0, 1.0) * kStep_m;
  return true;
}

/// State of each tick: 1 fired, -1 skipped between two firings, 0 unknown; minus the mean.
std::vector<double> firing_pattern(
    const std::vector<BeamPoint>& sweep, double side, double phase, int ticks, int longest_step) {
  std::vector<double> pattern(static_cast<std::size_t>(ticks), 0.0);
  std::vector<long> fired;
  for (const BeamPoint& p : sweep) {
    fired.push_back(std::lround((beam_azimuth(p, side) - phase) / kTurn * ticks));
  }
  std::sort(fired.begin(), fired.end());
  const auto at = [&](long tick) -> double& {
    return pattern[static_cast<std::size_t>(((tick % ticks) + ticks) % ticks)];
  };
  for (std::size_t i = 1; i < fired.size(); ++i) {
    const long step = fired[i] - fired[i - 1];
    if (step < 1 || step > longest_step) continue;
    at(fired[i - 1]) = at(fired[i]) = 1.0;
    for (long k = fired[i - 1] + 1; k < fired[i]; ++k) at(k) = -1.0;
  }
  double sum = 0.0;
  double known = 0.0;
  for (const double value : pattern) {
    sum += value;
    known += value != 0.0 ? 1.0 : 0.0;
  }
  for (double& value : pattern) {
    if (value != 0.0) value -= sum / std::max(1.0, known);
  }
  return pattern;
}

/// Finds the shift in ticks with the best agreement of two rows' patterns over all sweeps; false unless it is
/// better than others by four standard deviations.
bool find_shift(const std::vector<std::vector<Complex>>& base,
                const std::vector<std::vector<Complex>>& row,
                int ticks,
                int& shift) {
  const int reach = ticks / 18;  // 20 degrees
  Eigen::FFT<double> fft;
  std::vector<std::vector<double>> agreements;  // [sweeps][2 reach + 1]
  std::vector<double> total(static_cast<std::size_t>(2 * reach + 1), 0.0);
  for (std::size_t s = 0; s < base.size(); ++s) {
    std::vector<Complex> product(base[s].size());
    for (std::size_t k = 0; k < product.size(); ++k) product[k] = row[s][k] * std::conj(base[s][k]);
    std::vector<Complex> agreement;
    fft.inv(agreement, product);
    std::vector<double>& near = agreements.emplace_back();
    for (int lag = -reach; lag <= reach; ++lag) {
      near.push_back(agreement[static_cast<std::size_t>((lag + ticks) % ticks)].real());
      total[static_cast<std::size_t>(lag + reach)] += near.back();
    }
  }
  const auto best = std::max_element(total.begin(), total.end()) - total.begin();
  std::ptrdiff_t second = best == 0 ? 1 : 0;
  for (std::ptrdiff_t i = 0; i < std::ssize(total); ++i) {
    if (i != best && total[static_cast<std::size_t>(i)] > total[static_cast<std::size_t>(second)]) second = i;
  }
  const auto lead = [&](const std::vector<double>& near) {
    return near[static_cast<std::size_t>(best)] - near[static_cast<std::size_t>(second)];
  };
  const auto count = static_cast<double>(agreements.size());
  const double mean = lead(total) / count;
  double square = 0.0;
  for (const auto& near : agreements) square += (lead(near) - mean) * (lead(near) - mean);
  shift = static_cast<int>(best) - reach;
  return count >= 3.0 && mean > 0.0 && mean * mean * count * (count - 1.0) >= 16.0 * square;
}

/// Mean step between neighbouring firings, in the unit of `steps`, using steps near the most common one.
/// `usual` is the median.
double mean_single_step(const std::vector<double>& steps, double usual) {
  double sum = 0.0;
  double count = 0.0;
  for (const double step : steps) {
    if (!(step > 0.4 * usual && step < 1.5 * usual - 1e-9)) continue;
    sum += step;
    count += 1.0;
  }
  return count >= 1000.0 ? sum / count : 0.0;
}

/// Initial estimate from steps between neighbouring returns of single beams; missing returns may merge two
/// firings.
double columns_by_steps(const BeamPoints& points, const BeamTable& table) {
  std::vector<double> steps;
  for (std::size_t r = 0; r < points.size(); ++r) {
    const double side = table.rows[r].row.horizontal_offset;
    for (const auto& sweep : points[r]) {
      for (std::size_t i = 1; i < sweep.size(); ++i) {
        steps.push_back(beam_azimuth(sweep[i], side) - beam_azimuth(sweep[i - 1], side));
      }
    }
  }
  if (steps.empty()) return 0.0;
  const double step = mean_single_step(steps, upper_median(steps));
  return step > 0.0 ? kTurn / step : 0.0;
}

/// From the ticks at which any beam fired, all beams overlaid; 0 with too few.
double columns_by_firings(const BeamPoints& points, const BeamTable& table) {
  constexpr double kCut_rad = 0.5;  // around the cut, beams show ticks of two revolutions
  constexpr double kOfMost = 0.15;
  const int ticks = table.encoder_ticks;
  std::size_t known = 0;
  for (const BeamEstimate& beam : table.rows) known += beam.azimuth_offset_known ? 1U : 0U;
  if (known < 4) return 0.0;
  // Offsets are relative to one beam, whose azimuths have any phase relative to the ticks.
  std::vector<double> places;  // phase of each beam's grid, rad
  for (std::size_t r = 0; r < points.size(); ++r) {
    const LidarRow& row = table.rows[r].row;
    places.push_back(row.azimuth_offset + std::arg(grid_phasor(points[r], ticks, row.horizontal_offset) *
                                                   std::polar(1.0, -ticks * row.azimuth_offset)) /
                                              ticks);
  }
  double fired = 0.0;
  double looked_at = 0.0;
  for (std::size_t s = 0; s < points.front().size(); ++s) {
    std::vector<int> beams(static_cast<std::size_t>(ticks), 0);
    for (std::size_t r = 0; r < points.size(); ++r) {
      if (!table.rows[r].azimuth_offset_known) continue;
      const double side = table.rows[r].row.horizontal_offset;
      for (const BeamPoint& p : points[r][s]) {
        const long tick = std::lround((beam_azimuth(p, side) - places[r]) / kTurn * ticks);
        ++beams[static_cast<std::size_t>((tick % ticks + ticks) % ticks)];
      }
    }
    const int most = *std::max_element(beams.begin(), beams.end());
    for (int k = 0; k < ticks; ++k) {
      const double azimuth = std::remainder(k * kTurn / ticks, kTurn);
      if (std::abs(azimuth) > std::numbers::pi - kCut_rad) continue;
      looked_at += 1.0;
      fired += beams[static_cast<std::size_t>(k)] > std::max(1.0, kOfMost * most) ? 1.0 : 0.0;
    }
  }
  return fired / looked_at * ticks;
}

void set_columns(const BeamPoints& points, BeamTable& table) {
  const double by_firings = table.encoder_ticks > 0 ? columns_by_firings(points, table) : 0.0;
  if (by_firings > 0.0) table.columns = by_firings;
  if (!(table.columns > 0.0)) {
    table.notes.emplace_back("firings per turn: not determined, too few neighbouring returns");
    return;
  }
  std::size_t sweeps = 0;
  for (std::size_t s = 0; s < points.front().size(); ++s) {
    sweeps +=
        std::any_of(points.begin(), points.end(), [&](const auto& row) { return !row[s].empty(); }) ? 1U : 0U;
  }
  std::size_t placed = 0;
  for (const BeamEstimate& beam : table.rows) placed += beam.points;
  table.returned_share =
      static_cast<double>(placed) / (table.columns * static_cast<double>(points.size() * sweeps));
}

void find_azimuth_offsets(const BeamPoints& points, std::size_t base, BeamTable& table) {
  const int ticks = table.encoder_ticks;
  const double step = table.columns > 0.0 ? ticks / table.columns : 0.0;
  const int longest_step = static_cast<int>(std::ceil(step - 1e-6));
  const std::size_t rows = points.size();
  std::vector<double> phase(rows);
  std::vector<std::vector<std::vector<Complex>>> spectra(rows);  // [rows][sweeps][ticks]
  Eigen::FFT<double> fft;
  for (std::size_t r = 0; r < rows; ++r) {
    if (!table.rows[r].horizontal_offset_known) continue;
    const double side = table.rows[r].row.horizontal_offset;
    phase[r] = std::arg(grid_phasor(points[r], ticks, side)) / ticks;
    for (const auto& sweep : points[r]) {
      fft.fwd(spectra[r].emplace_back(), firing_pattern(sweep, side, phase[r], ticks, longest_step));
    }
  }
  std::size_t unknown = 0;
  for (std::size_t r = 0; r < rows; ++r) {
    BeamEstimate& beam = table.rows[r];
    int shift = 0;
    beam.azimuth_offset_known =
        beam.horizontal_offset_known && (r == base || find_shift(spectra[base], spectra[r], ticks, shift));
    if (beam.azimuth_offset_known) {
      beam.row.azimuth_offset = phase[r] - phase[base] + shift * kTurn / ticks;
    } else {
      ++unknown;
    }
  }
  if (unknown == 0) return;
  table.notes.push_back(
      fmt::format("azimuth offset of {} of {} beams: not determined, because their firing times show no "
                  "clear pattern; set to 0",
                  unknown,
                  rows));
}

}  // namespace

void find_azimuths(const BeamPoints& points, BeamTable& table) {
  std::vector<std::size_t> fullest(points.size());
  std::iota(fullest.begin(), fullest.end(), std::size_t{0});
  std::stable_sort(fullest.begin(), fullest.end(), [&](std::size_t a, std::size_t b) {
    return table.rows[a].points > table.rows[b].points;
  });
  table.encoder_ticks = find_ticks(points, fullest);
  if (table.encoder_ticks == 0) {
    table.notes.emplace_back(
        "horizontal and azimuth offsets: not determined, azimuths lie on no grid of 300 to 8000 ticks; set "
        "to 0");
    table.columns = columns_by_steps(points, table);
    set_columns(points, table);
    return;
  }
  std::size_t unknown = 0;
  for (std::size_t r = 0; r < points.size(); ++r) {
    BeamEstimate& beam = table.rows[r];
    double side = 0.0;
    beam.horizontal_offset_known = find_side(points[r], table.encoder_ticks, side);
    if (beam.horizontal_offset_known) beam.row.horizontal_offset = side;
    unknown += beam.horizontal_offset_known ? 0U : 1U;
  }
  if (unknown > 0) {
    table.notes.push_back(fmt::format(
        "horizontal offset of {} of {} rows: not determined, their azimuths fit the grid of {} ticks "
        "equally well with any; set to 0",
        unknown,
        points.size(),
        table.encoder_ticks));
  }
  table.columns = columns_by_steps(points, table);
  find_azimuth_offsets(points, fullest.front(), table);
  set_columns(points, table);
}

}  // namespace simuli::calibration
