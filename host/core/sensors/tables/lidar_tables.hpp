#pragma once
// The built-in beam tables of lidar_tables_*.cpp; lidar_library.cpp converts them to models.
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include "host/core/sensors/lidar_library.hpp"

namespace simuli {

/// Rows `first` to `last` fire in one of `every` columns each, alternating in groups of `group` rows.
struct SlowRows {
  int first = 0, last = 0, every = 1, group = 1;
};

/// Angles in microradians, lever arms in 0.1 mm, times in ns: integers, as published. An empty list means
/// zeros; the others have one value per beam, top beam first.
struct LidarTable {
  static constexpr std::int32_t kFromBehind = std::numeric_limits<std::int32_t>::min();

  const char* name = "";
  std::span<const std::int32_t> elevation_urad{};
  std::span<const std::int32_t> azimuth_offset_urad{};  // positive to the left
  // Both are perpendicular to the beam: a vertical offset tilts with the elevation, a horizontal one points to
  // the left.
  std::span<const std::int32_t> vertical_offset_100um{};
  std::span<const std::int32_t> horizontal_offset_100um{};
  std::span<const std::int32_t> time_offset_ns{};
  std::int32_t beam_origin_um = 0;  // radius of the circle of beam origins, which rotates with the head
  std::int32_t height_um = 0;       // of the beams' common plane above the sensor frame
  std::span<const LidarMode> modes{};
  std::span<const SlowRows> slow{};  // other rows fire in each column
  std::int32_t azimuth_first_urad = kFromBehind;  // kFromBehind: half a column after the back
  std::int32_t azimuth_span_urad = 0;  // 0: a full revolution
  double range_min_m = 0.0;
  double range_max_m = 0.0;
  std::int32_t divergence_horizontal_urad = 0;  // 0: unknown
  std::int32_t divergence_vertical_urad = 0;
  double divergence_variance = 0.25;
  const char* source = "";
  const char* licence = "";
  const char* note = "";
};

/// Concatenates values.
template <std::size_t N>
constexpr std::array<std::int32_t, N> in_steps(std::int32_t first, std::int32_t step) {
  std::array<std::int32_t, N> values{};
  for (std::size_t i = 0; i < N; ++i) values[i] = first + static_cast<std::int32_t>(i) * step;
  return values;
}
/// Angles from a first one downwards, in steps.
template <std::size_t N>
constexpr std::array<std::int32_t, N> in_steps_deg(double first_deg, double step_deg) {
  std::array<std::int32_t, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    const double urad = (first_deg - static_cast<double>(i) * step_deg) * (1e6 * std::numbers::pi / 180.0);
    values[i] = static_cast<std::int32_t>(urad + (urad < 0.0 ? -0.5 : 0.5));
  }
  return values;
}
/// Repeats the values.
template <std::size_t N, std::size_t M>
constexpr std::array<std::int32_t, N> repeated(const std::array<std::int32_t, M>& values) {
  std::array<std::int32_t, N> all{};
  for (std::size_t i = 0; i < N; ++i) all[i] = values[i % M];
  return all;
}

[[nodiscard]] std::span<const LidarTable> datasets_lidar_tables();
[[nodiscard]] std::span<const LidarTable> hesai_lidar_tables();
[[nodiscard]] std::span<const LidarTable> ouster_lidar_tables();
[[nodiscard]] std::span<const LidarTable> robosense_lidar_tables();
[[nodiscard]] std::span<const LidarTable> velodyne_lidar_tables();

}  // namespace simuli
