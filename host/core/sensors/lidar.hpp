#pragma once
// Spinning LiDAR model: rows (beams) x columns (firings). Frame: x forward, y left, z up; azimuth = atan2(y,
// x), counter-clockwise positive seen from above; elevation positive up. Angles in radians.
#include <Eigen/Core>
#include <string>
#include <vector>

namespace simuli {

enum class SpinDirection { kCounterClockwise, kClockwise };

/// One beam. Its ray at azimuth phi starts at
///   (horizontal_offset * (-sin phi, cos phi) + radial_offset * (cos phi, sin phi), vertical_offset)
/// and points along (elevation, phi).
struct LidarRow {
  double elevation = 0.0;          // rad
  double azimuth_offset = 0.0;     // rad, added to the column's azimuth
  double vertical_offset = 0.0;    // m, along z
  double horizontal_offset = 0.0;  // m, to the left of the beam
  double time_offset = 0.0;        // s, added to the column's firing time
  double radial_offset = 0.0;      // m, away from the spin axis
  double range_bias = 0.0;  // m, recorded minus true distance; corrected when sweeps are read
  int every = 1;  // the beam fires in one of so many columns,
  int first = 0;  // starting with this one

  bool operator==(const LidarRow&) const = default;
};

/// Azimuths [first, last] of a row, in the sensor frame, in which its beam hits the ego vehicle or never
/// returns.
struct BlindArc {
  int row = 0;
  double azimuth_first = 0.0;  // rad, 0 to 2 pi
  double azimuth_last = 0.0;   // rad, azimuth_first to 2 pi
  bool own_returns = false;  // its recorded returns belong to the ego vehicle; otherwise it has none

  bool operator==(const BlindArc&) const = default;
};

/// One revolution at 10 Hz, the default of automotive LiDARs.
inline constexpr double kUsualSweep_s = 0.1;
inline constexpr double kLongestSweep_s = 1000.0;

struct Lidar {
  std::string name;
  std::vector<LidarRow> rows;  // top to bottom: elevation never rising
  int columns = 0;
  double azimuth_first = 0.0;  // rad, azimuth of column 0
  double azimuth_span = 0.0;  // rad > 0, covered by all columns; 2 pi for a full revolution
  SpinDirection spin = SpinDirection::kCounterClockwise;
  double sweep_s = kUsualSweep_s;  // s > 0, between the starts of successive revolutions: duration of a frame
  double range_min = 0.0;             // m
  double range_max = 0.0;             // m
  double beam_divergence = 0.0;       // rad, full angle; 0: an ideal ray
  double divergence_variance = 0.25;  // k of METHOD section 8: 0.25 for 1/e^2, 0.72 FWHM, 1 sigma
  std::vector<BlindArc> blind;  // of a mounted sensor, by row, then by azimuth, disjoint

  [[nodiscard]] int row_count() const { return static_cast<int>(rows.size()); }
  [[nodiscard]] std::size_t ray_count() const { return rows.size() * static_cast<std::size_t>(columns); }
  /// Whether is_blind() is true for any ray.
  [[nodiscard]] bool has_blind() const;
  [[nodiscard]] double spin_sign() const { return spin == SpinDirection::kCounterClockwise ? 1.0 : -1.0; }
  /// Azimuth of (row, column) at the centre of its firing, not wrapped.
  [[nodiscard]] double azimuth(int row, int column) const;
  /// Share of the sweep at which (row, column) fires.
  [[nodiscard]] double time_fraction(int row, int column) const;
  /// Unit direction for a measured or nominal (azimuth, elevation).
  [[nodiscard]] static Eigen::Vector3d direction(double azimuth, double elevation);
  /// Origin in the sensor frame of the ray of `row` at `azimuth`.
  [[nodiscard]] Eigen::Vector3d origin(int row, double azimuth) const;
  bool operator==(const Lidar&) const = default;
};

/// Throws Error{kInput} with `file` and field for an invalid model.
void validate(const Lidar& lidar, const std::string& file);

/// Returns a built-in model by "name" or "name@mode" (host/core/sensors/lidar_library.hpp, which also has
/// sources); throws Error{kUsage} with similar names.
[[nodiscard]] Lidar builtin_lidar(const std::string& name);
[[nodiscard]] std::vector<std::string> builtin_lidar_names();

/// The rays of one sweep in row-major order, in the sensor frame at each ray's own time; measured or nominal.
struct LidarRays {
  int rows = 0;
  int columns = 0;
  std::vector<float> azimuth;        // [rows*columns] rad
  std::vector<float> elevation;      // [rows*columns] rad, from the ray's own origin
  std::vector<float> time_fraction;  // [rows*columns] 0 at the sweep's start, 1 at its end

  bool operator==(const LidarRays&) const = default;
};

[[nodiscard]] LidarRays nominal_rays(const Lidar& lidar);

/// Returns the number of columns in which a row fires.
[[nodiscard]] int firings_of(const Lidar& lidar, int row);

/// Whether a ray's (row-major) beam fires in its column.
[[nodiscard]] bool fires(const Lidar& lidar, std::size_t ray);

/// Whether a ray (row-major) at `azimuth` (rad, any period) cannot return: its beam does not fire in that
/// column, or fires into a blind arc.
[[nodiscard]] bool is_blind(const Lidar& lidar, std::size_t ray, double azimuth);

/// Returns the blind arc that contains a ray (row-major) at `azimuth` (rad, any period); nullptr without one.
[[nodiscard]] const BlindArc* blind_arc_of(const Lidar& lidar, std::size_t ray, double azimuth);

}  // namespace simuli
