#include "host/core/sensors/lidar.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "host/core/base/error.hpp"

namespace simuli {

double Lidar::azimuth(int row, int column) const {
  const double step = azimuth_span / columns;
  return azimuth_first + spin_sign() * step * column + rows[static_cast<std::size_t>(row)].azimuth_offset;
}

double Lidar::time_fraction(int row, int column) const {
  const double column_fraction = (column + 0.5) / columns;
  return column_fraction + rows[static_cast<std::size_t>(row)].time_offset / sweep_s;
}

Eigen::Vector3d Lidar::direction(double azimuth, double elevation) {
  return {
      std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

Eigen::Vector3d Lidar::origin(int row, double azimuth) const {
  const LidarRow& beam = rows[static_cast<std::size_t>(row)];
  const double sine = std::sin(azimuth);
  const double cosine = std::cos(azimuth);
  return {beam.radial_offset * cosine - beam.horizontal_offset * sine,
          beam.radial_offset * sine + beam.horizontal_offset * cosine,
          beam.vertical_offset};
}

namespace {

/// refuse(field, found, allowed) does not return.
template <class Refuse>
void validate_blind_arcs(const Lidar& lidar, const Refuse& refuse) {
  for (std::size_t i = 0; i < lidar.blind.size(); ++i) {
    const BlindArc& arc = lidar.blind[i];
    const std::string name = fmt::format("blind_arcs[{}].", i);
    if (arc.row < 0 || arc.row >= lidar.row_count()) refuse(name + "row", arc.row, "a row of the sensor");
    const BlindArc* last = i > 0 && lidar.blind[i - 1].row == arc.row ? &lidar.blind[i - 1] : nullptr;
    if (i > 0 && arc.row < lidar.blind[i - 1].row) refuse(name + "row", arc.row, "rows in order");
    if (!(arc.azimuth_first >= (last != nullptr ? last->azimuth_last : 0.0))) {
      refuse(name + "azimuth_first_rad", arc.azimuth_first, "0 or more and behind the row's arc before");
    }
    if (!(arc.azimuth_last >= arc.azimuth_first && arc.azimuth_last <= 2.0 * std::numbers::pi)) {
      refuse(name + "azimuth_last_rad", arc.azimuth_last, "azimuth_first_rad to 2 pi");
    }
  }
}

}  // namespace

void validate(const Lidar& lidar, const std::string& file) {
  const std::string prefix = "lidar " + lidar.name + ": ";
  const auto refuse = [&](const std::string& field, double found, const char* allowed) {
    throw_input_error(file, prefix + field, fmt::format("{}", found), allowed);
  };
  if (lidar.rows.empty() || lidar.rows.size() > 4096) {
    refuse("rows", static_cast<double>(lidar.rows.size()), "1 to 4096");
  }
  if (lidar.columns < 1 || lidar.columns > 1 << 20) refuse("columns", lidar.columns, "1 to 1048576");
  for (std::size_t i = 0; i < lidar.rows.size(); ++i) {
    const LidarRow& row = lidar.rows[i];
    const std::string name = fmt::format("rows[{}].", i);
    if (!(std::abs(row.elevation) <= std::numbers::pi / 2)) {
      refuse(name + "elevation_rad", row.elevation, "-pi/2 to pi/2");
    }
    if (!(std::abs(row.azimuth_offset) <= std::numbers::pi)) {
      refuse(name + "azimuth_offset_rad", row.azimuth_offset, "-pi to pi");
    }
    if (!(std::abs(row.vertical_offset) <= 10.0)) {
      refuse(name + "vertical_offset_m", row.vertical_offset, "-10 to 10");
    }
    if (!(std::abs(row.horizontal_offset) <= 10.0)) {
      refuse(name + "horizontal_offset_m", row.horizontal_offset, "-10 to 10");
    }
    if (!(std::abs(row.radial_offset) <= 10.0)) {
      refuse(name + "radial_offset_m", row.radial_offset, "-10 to 10");
    }
    if (!(std::abs(row.range_bias) <= 1.0)) refuse(name + "range_bias_m", row.range_bias, "-1 to 1");
    if (!(std::abs(row.time_offset) <= 1.0)) refuse(name + "time_offset_s", row.time_offset, "-1 to 1");
    if (row.every < 1 || row.every > lidar.columns) refuse(name + "fires_every", row.every, "1 to columns");
    if (row.first < 0 || row.first >= row.every)
      refuse(name + "fires_first", row.first, "0 to below fires_every");
    if (i > 0 && !(row.elevation <= lidar.rows[i - 1].elevation)) {
      refuse(name + "elevation_rad", row.elevation, "rows sorted from top to bottom");
    }
  }
  if (!std::isfinite(lidar.azimuth_first)) refuse("azimuth_first_rad", lidar.azimuth_first, "finite");
  if (!(lidar.azimuth_span > 0.0 && lidar.azimuth_span <= 2.0 * std::numbers::pi + 1e-9)) {
    refuse("azimuth_span_rad", lidar.azimuth_span, "above 0, at most 2 pi");
  }
  if (!(lidar.sweep_s > 0.0 && lidar.sweep_s <= kLongestSweep_s)) {
    refuse("sweep_s", lidar.sweep_s, "above 0, at most 1000");
  }
  if (!(lidar.range_min >= 0.0)) refuse("range_min_m", lidar.range_min, "at least 0");
  if (!(lidar.range_max > lidar.range_min && std::isfinite(lidar.range_max))) {
    refuse("range_max_m", lidar.range_max, "finite and above range_min_m");
  }
  if (!(lidar.beam_divergence >= 0.0 && lidar.beam_divergence < 0.5)) {
    refuse("beam_divergence_rad", lidar.beam_divergence, "0 to 0.5");
  }
  if (!(lidar.divergence_variance >= 0.0 && lidar.divergence_variance <= 10.0)) {
    refuse("divergence_variance", lidar.divergence_variance, "0 to 10");
  }
  validate_blind_arcs(lidar, refuse);
}

LidarRays nominal_rays(const Lidar& lidar) {
  LidarRays rays{lidar.row_count(), lidar.columns, {}, {}, {}};
  const std::size_t count = lidar.ray_count();
  rays.azimuth.reserve(count);
  rays.elevation.reserve(count);
  rays.time_fraction.reserve(count);
  for (int r = 0; r < lidar.row_count(); ++r) {
    for (int c = 0; c < lidar.columns; ++c) {
      const double azimuth = std::remainder(lidar.azimuth(r, c), 2.0 * std::numbers::pi);
      rays.azimuth.push_back(static_cast<float>(azimuth));
      rays.elevation.push_back(static_cast<float>(lidar.rows[static_cast<std::size_t>(r)].elevation));
      rays.time_fraction.push_back(static_cast<float>(lidar.time_fraction(r, c)));
    }
  }
  return rays;
}

bool Lidar::has_blind() const {
  return !blind.empty() ||
         std::any_of(rows.begin(), rows.end(), [](const LidarRow& row) { return row.every > 1; });
}

int firings_of(const Lidar& lidar, int row) {
  const LidarRow& beam = lidar.rows[static_cast<std::size_t>(row)];
  return (lidar.columns - beam.first + beam.every - 1) / beam.every;
}

bool fires(const Lidar& lidar, std::size_t ray) {
  const auto columns = static_cast<std::size_t>(lidar.columns);
  const LidarRow& beam = lidar.rows[ray / columns];
  return static_cast<int>(ray % columns) % beam.every == beam.first;
}

bool is_blind(const Lidar& lidar, std::size_t ray, double azimuth) {
  return !fires(lidar, ray) || blind_arc_of(lidar, ray, azimuth) != nullptr;
}

const BlindArc* blind_arc_of(const Lidar& lidar, std::size_t ray, double azimuth) {
  const int row = static_cast<int>(ray / static_cast<std::size_t>(lidar.columns));
  const double turn = azimuth - 2.0 * std::numbers::pi * std::floor(azimuth / (2.0 * std::numbers::pi));
  // Only the last arc that begins at or before the ray can contain it.
  const auto behind = std::upper_bound(
      lidar.blind.begin(), lidar.blind.end(), turn, [row](double angle, const BlindArc& arc) {
        return arc.row > row || (arc.row == row && arc.azimuth_first > angle);
      });
  if (behind == lidar.blind.begin()) return nullptr;
  const BlindArc& arc = *std::prev(behind);
  return arc.row == row && turn <= arc.azimuth_last ? &arc : nullptr;
}

}  // namespace simuli
