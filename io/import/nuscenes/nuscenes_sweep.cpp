#include "io/import/nuscenes/nuscenes_sweep.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"

namespace simuli::nuscenes {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBeams = 32;
constexpr std::size_t kPoint_bytes = 20;
constexpr std::size_t kFiring_bytes = kBeams * kPoint_bytes;
constexpr double kNearest_m = 1.0F;    // from the sensor; closer points mean no return
constexpr double kMostOff_rad = 0.02;  // deviation of a return's elevation from its beam's

std::array<float, 5> point_at(const std::string& bytes, std::size_t index) {
  static_assert(std::endian::native == std::endian::little, "the files are little endian");
  std::array<float, 5> v{};
  std::memcpy(v.data(), bytes.data() + index * kPoint_bytes, kPoint_bytes);
  return v;
}

std::size_t firings_of(std::uintmax_t bytes, const fs::path& file) {
  if (bytes > 0 && bytes % kFiring_bytes == 0) return bytes / kFiring_bytes;
  throw_input_error(file.string(), "size", fmt::format("{} bytes", bytes), "a multiple of 640 (32 beams)");
}

struct Point {
  Eigen::Vector3d position;  // m, in the sensor's frame at the time of measurement; zero: no return
  float intensity = 0.0F;
};

/// Returns [columns][32] points transformed to their time of measurement; files contain them in the frame at
/// the sweep's end.
std::vector<Point> points_of(const std::string& bytes,
                             const fs::path& file,
                             const Lidar& lidar,
                             const Pose& start_from_end) {
  std::vector<Point> points;
  const auto columns = static_cast<std::size_t>(lidar.columns);
  for (std::size_t c = 0; c < columns; ++c) {
    const Pose own_from_end =
        interpolate(start_from_end, Pose{}, (static_cast<double>(c) + 0.5) / static_cast<double>(columns));
    for (std::size_t ring = 0; ring < kBeams; ++ring) {
      const auto v = point_at(bytes, c * kBeams + ring);
      const auto refuse = [&](const char* what, float found, const char* allowed) {
        throw_input_error(file.string(),
                          fmt::format("point {}: {}", c * kBeams + ring, what),
                          fmt::format("{}", found),
                          allowed);
      };
      if (v[4] != static_cast<float>(ring)) refuse("ring", v[4], "0 to 31 in each firing, in order");
      for (const float x : {v[0], v[1], v[2]}) {
        if (!(std::abs(x) < 1e4F)) refuse("position", x, "-10000 to 10000 m");
      }
      if (!(v[3] >= 0.0F && v[3] <= 255.0F)) refuse("intensity", v[3], "0 to 255");
      const Eigen::Vector3d p = own_from_end * Eigen::Vector3d(v[0], v[1], v[2]);
      const double elevation = std::atan2(p.z(), p.head<2>().norm());
      // An elevation error larger than any calibration's is an artefact without a return.
      const bool returned = p.norm() >= kNearest_m &&
                            std::abs(elevation - lidar.rows[kBeams - 1 - ring].elevation) <= kMostOff_rad;
      points.push_back({returned ? p : Eigen::Vector3d::Zero(), v[3] / 255.0F});
    }
  }
  return points;
}

/// Returns the mean azimuth of a firing's returns; NaN without any.
double firing_azimuth(const std::vector<Point>& points, std::size_t firing) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t ring = 0; ring < kBeams; ++ring) {
    const Eigen::Vector2d flat = points[firing * kBeams + ring].position.head<2>();
    if (flat.norm() > 0.0) sum += flat.normalized();
  }
  return sum.isZero() ? std::numeric_limits<double>::quiet_NaN() : std::atan2(sum.y(), sum.x());
}

/// Returns the azimuths of all firings, interpolated uniformly where nothing returned.
std::vector<double> azimuths_of(const std::vector<Point>& points, const Lidar& lidar) {
  std::vector<double> azimuths;
  std::size_t last = 0;
  bool any = false;
  for (int c = 0; c < lidar.columns; ++c) {
    const double nominal = lidar.azimuth(0, c);
    double a = firing_azimuth(points, static_cast<std::size_t>(c));
    // The revolution nearest to the nominal azimuth, so that the seam causes no jump.
    if (std::isfinite(a)) a = nominal + std::remainder(a - nominal, 2.0 * std::numbers::pi);
    azimuths.push_back(a);
  }
  const auto shift = [&](std::size_t c) { return azimuths[c] - lidar.azimuth(0, static_cast<int>(c)); };
  for (std::size_t c = 0; c < azimuths.size(); ++c) {
    if (!std::isfinite(azimuths[c])) continue;
    for (std::size_t k = any ? last + 1 : 0; k < c; ++k) {
      const double u = any ? static_cast<double>(k - last) / static_cast<double>(c - last) : 1.0;
      azimuths[k] =
          lidar.azimuth(0, static_cast<int>(k)) + (any ? (1.0 - u) * shift(last) : 0.0) + u * shift(c);
    }
    last = c;
    any = true;
  }
  for (std::size_t k = any ? last + 1 : 0; k < azimuths.size(); ++k) {
    azimuths[k] = lidar.azimuth(0, static_cast<int>(k)) + (any ? shift(last) : 0.0);
  }
  return azimuths;
}

}  // namespace

Lidar lidar_of(const std::vector<fs::path>& files, const std::string& name) {
  Lidar lidar = builtin_lidar("nuscenes_lidar_top_hdl32e");
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const fs::path& file : files) {
    need_regular_file(file);
    std::error_code failed;
    const std::uintmax_t bytes = fs::file_size(file, failed);
    if (failed) throw_input_error(file.string(), "sweep", failed.message(), "a file");
    fewest = std::min(fewest, firings_of(bytes, file));
  }
  constexpr std::size_t kMost = 4096;
  if (fewest > kMost) {
    throw_input_error(files.front().string(), "firings", fmt::format("{}", fewest), "at most 4096");
  }
  lidar.name = name;
  lidar.columns = static_cast<int>(fewest);
  lidar.azimuth_first = std::numbers::pi * (1.0 - 1.0 / static_cast<double>(fewest));
  return lidar;
}

Sweep read_turn(const fs::path& file, const Lidar& lidar, const Pose& start_from_end) {
  const std::string bytes = read_file(file, std::size_t{64} << 20U);
  const auto columns = static_cast<std::size_t>(lidar.columns);
  if (firings_of(bytes.size(), file) < columns) {
    throw_input_error(file.string(), "firings", "fewer", fmt::format("at least {}", columns));
  }
  Sweep sweep;
  Lidar firings = lidar;  // the file has one time per firing, not per beam
  for (LidarRow& row : firings.rows) row.time_offset = 0.0;
  sweep.rays = nominal_rays(firings);
  sweep.range.assign(lidar.ray_count(), 0.0F);
  sweep.intensity.assign(lidar.ray_count(), 0.0F);
  const std::vector<Point> points = points_of(bytes, file, lidar, start_from_end);
  const std::vector<double> azimuths = azimuths_of(points, lidar);
  for (std::size_t c = 0; c < columns; ++c) {
    for (std::size_t ring = 0; ring < kBeams; ++ring) {
      const std::size_t ray = (kBeams - 1 - ring) * columns + c;
      const auto& [p, intensity] = points[c * kBeams + ring];
      double azimuth = azimuths[c];
      if (!p.isZero()) {
        azimuth += std::remainder(std::atan2(p.y(), p.x()) - azimuth, 2.0 * std::numbers::pi);
        sweep.rays.elevation[ray] = static_cast<float>(std::atan2(p.z(), p.head<2>().norm()));
        sweep.range[ray] = static_cast<float>(p.norm());
        sweep.intensity[ray] = intensity;
      }
      sweep.rays.azimuth[ray] = static_cast<float>(azimuth);
    }
  }
  return sweep;
}

}  // namespace simuli::nuscenes
