// Reconstruction of a sweep's firing grid. The recorded files contain returns only; training of ray drop needs
// the rays without return.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/import/kitti/kitti_parts.hpp"

namespace simuli::kitti {
namespace {

namespace fs = std::filesystem;

/// Beams of the HDL-64E are 4 to 13 mrad apart; points are within 0.4 mrad of their beam.
constexpr double kElevationTolerance_rad = 2e-3;
/// Closer points are not echoes: their direction is noise.
constexpr double kNearest_m = 0.1;

double azimuth_of(const Eigen::Vector3d& p) { return std::atan2(p.y(), p.x()); }

/// Returns the azimuth of the beam's ray through p, which passes horizontal_offset to the left of the spin
/// axis.
double beam_azimuth(const LidarRow& row, const Eigen::Vector3d& p) {
  const double axis_distance = std::hypot(p.x(), p.y());
  if (row.horizontal_offset == 0.0 || !(axis_distance > 0.0)) return azimuth_of(p);
  return azimuth_of(p) - std::asin(std::clamp(row.horizontal_offset / axis_distance, -1.0, 1.0));
}

/// Returns the elevation of a point as seen from the beam's intersection with the spin axis.
double elevation_from(const LidarRow& row, const Eigen::Vector3d& p) {
  const double side = row.horizontal_offset;
  const double along = std::sqrt(std::max(0.0, p.head<2>().squaredNorm() - side * side));
  return std::atan2(p.z() - row.vertical_offset, along);
}

/// A beam as a line in the plane of spin axis and point.
struct BeamLine {
  double sin_elevation, cos_elevation, height_m;
};

std::vector<BeamLine> beam_lines(const Lidar& lidar) {
  std::vector<BeamLine> lines;
  for (const LidarRow& row : lidar.rows) {
    lines.push_back({std::sin(row.elevation), std::cos(row.elevation), row.vertical_offset});
  }
  return lines;
}

/// Returns the beam nearest in elevation, or -1 if none is near. The distance of a point from the beam's line
/// divided by its range is the sine of the angle between them, which avoids an atan2 per beam and point.
int nearest_row(const std::vector<BeamLine>& lines, const Eigen::Vector3d& p) {
  const double axis_distance = std::hypot(p.x(), p.y());
  const double range = p.norm();
  int best = -1;
  double smallest = kElevationTolerance_rad;
  if (!(range >= kNearest_m)) return best;
  for (std::size_t r = 0; r < lines.size(); ++r) {
    const BeamLine& line = lines[r];
    const double off =
        std::abs((p.z() - line.height_m) * line.cos_elevation - axis_distance * line.sin_elevation) / range;
    if (off <= smallest) {
      smallest = off;
      best = static_cast<int>(r);
    }
  }
  return best;
}

/// Returns the most frequent row >= 0 of rows [first, last), -1 without one.
int majority(const std::vector<int>& rows, std::size_t first, std::size_t last, int row_count) {
  std::vector<int> votes(static_cast<std::size_t>(row_count));
  for (std::size_t i = first; i < last; ++i) {
    if (rows[i] >= 0) ++votes[static_cast<std::size_t>(rows[i])];
  }
  const auto most = std::max_element(votes.begin(), votes.end());
  return *most > 0 ? static_cast<int>(most - votes.begin()) : -1;
}

}  // namespace

std::vector<Point> read_points(const fs::path& file, bool needs_places) {
  static_assert(std::endian::native == std::endian::little, "the files are little endian");
  constexpr std::size_t kPoint_bytes = 16;
  constexpr double kFarthest_m = 1e4;
  const std::string bytes = read_file(file, std::size_t{1} << 30U);
  if (bytes.size() % kPoint_bytes != 0) {
    throw_input_error(
        file.string(), "size", fmt::format("{} bytes", bytes.size()), "a multiple of 16 (4 floats a point)");
  }
  std::vector<Point> points(bytes.size() / kPoint_bytes);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::array<float, 4> v{};
    std::memcpy(v.data(), bytes.data() + i * kPoint_bytes, kPoint_bytes);
    for (std::size_t k = 0; k < v.size(); ++k) {
      const bool good =
          k < 3 ? std::abs(v[k]) <= kFarthest_m : needs_places || (v[k] >= 0.0F && v[k] <= 1.0F);
      if (good) continue;
      constexpr std::array<const char*, 4> kNames{"x", "y", "z", "reflectance"};
      throw_input_error(file.string(),
                        fmt::format("point {}: {}", i, kNames[k]),
                        fmt::format("{}", v[k]),
                        k < 3 ? "-10000 to 10000 m" : "0 to 1");
    }
    points[i] = {Eigen::Vector3d(v[0], v[1], v[2]), v[3]};
  }
  return points;
}

BeamPoints sort_into_beams(const std::vector<Point>& points, const Lidar& lidar) {
  const int row_count = lidar.row_count();
  const std::vector<BeamLine> lines = beam_lines(lidar);
  std::vector<int> row_of(points.size());
  std::vector<std::size_t> ring_starts{0};
  double last_turn = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    row_of[i] = nearest_row(lines, points[i].position);
    // The points of a ring are counter-clockwise from 0 to 2 pi; the next ring begins where the azimuth
    // decreases.
    const double azimuth = azimuth_of(points[i].position);
    const double turn = azimuth < 0.0 ? azimuth + 2.0 * kPi : azimuth;
    if (turn < last_turn - kPi) ring_starts.push_back(i);
    last_turn = turn;
  }
  ring_starts.push_back(points.size());

  BeamPoints beams;
  beams.rows.resize(static_cast<std::size_t>(row_count));
  for (std::size_t ring = 0; ring + 1 < ring_starts.size(); ++ring) {
    const int ring_row = majority(row_of, ring_starts[ring], ring_starts[ring + 1], row_count);
    for (std::size_t i = ring_starts[ring]; i < ring_starts[ring + 1]; ++i) {
      if (row_of[i] < 0) {
        ++beams.unplaced;
        continue;
      }
      if (row_of[i] == ring_row) ++beams.ring_agrees;
      beams.rows[static_cast<std::size_t>(row_of[i])].push_back(points[i]);
    }
  }
  for (std::size_t r = 0; r < beams.rows.size(); ++r) {
    const LidarRow& row = lidar.rows[r];
    std::stable_sort(beams.rows[r].begin(), beams.rows[r].end(), [&row](const Point& a, const Point& b) {
      return beam_azimuth(row, a.position) > beam_azimuth(row, b.position);
    });
  }
  return beams;
}

double estimate_columns(const BeamPoints& beams, const Lidar& lidar) {
  // number for which the mean step has an error of 1 %: 0.3 of a step / sqrt(1000)
  constexpr std::size_t kFewest = 1000;
  const double nominal_step = lidar.azimuth_span / lidar.columns;
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t r = 0; r < beams.rows.size(); ++r) {
    const std::vector<Point>& row = beams.rows[r];
    for (std::size_t i = 1; i < row.size(); ++i) {
      const double step =
          beam_azimuth(lidar.rows[r], row[i - 1].position) - beam_azimuth(lidar.rows[r], row[i].position);
      // The encoder rounds to 0.09 degree: consecutive firings are 0.54 or 1.08 of the mean step apart. Larger
      // steps contain firings without return, smaller steps are echoes of one firing.
      if (!(step > 0.4 * nominal_step && step < 1.5 * nominal_step)) continue;
      sum += step;
      ++count;
    }
  }
  return count >= kFewest ? 2.0 * kPi * static_cast<double>(count) / sum : 0.0;
}

std::vector<int> assign_columns(const std::vector<double>& azimuths_rad, int columns) {
  const int count = static_cast<int>(azimuths_rad.size());
  if (count > columns) {
    throw_input_error(
        "sweep", "points of one beam", std::to_string(count), fmt::format("at most {}", columns));
  }
  // Columns c_i strictly increase exactly if c_i - i never decreases: an isotonic regression of the ideal
  // columns minus i, solved by pooling adjacent violators.
  struct Pool {
    double sum;
    int count;
  };
  std::vector<Pool> pools;
  for (int i = 0; i < count; ++i) {
    const double ideal = (kPi - azimuths_rad[static_cast<std::size_t>(i)]) / (2.0 * kPi) * columns - 0.5;
    pools.push_back({ideal - i, 1});
    while (pools.size() > 1) {
      const Pool top = pools.back();
      Pool& below = pools[pools.size() - 2];
      if (below.sum / below.count <= top.sum / top.count) break;
      below.sum += top.sum;
      below.count += top.count;
      pools.pop_back();
    }
  }
  std::vector<int> out;
  out.reserve(azimuths_rad.size());
  for (const Pool& pool : pools) {
    const double offset = std::clamp(pool.sum / pool.count, 0.0, static_cast<double>(columns - count));
    for (int k = 0; k < pool.count; ++k) {
      out.push_back(static_cast<int>(std::lround(offset)) + static_cast<int>(out.size()));
    }
  }
  return out;
}

Sweep make_sweep(const BeamPoints& beams, const Lidar& lidar) {
  Sweep sweep;
  sweep.rays = nominal_rays(lidar);
  sweep.range.assign(lidar.ray_count(), 0.0F);
  sweep.intensity.assign(lidar.ray_count(), 0.0F);
  const auto columns = static_cast<std::size_t>(lidar.columns);
  for (std::size_t r = 0; r < beams.rows.size(); ++r) {
    const std::vector<Point>& points = beams.rows[r];
    if (points.empty()) continue;  // the whole revolution is nominal
    const LidarRow& row = lidar.rows[r];
    std::vector<double> azimuths;
    azimuths.reserve(points.size());
    for (const Point& point : points) azimuths.push_back(beam_azimuth(row, point.position));
    const std::vector<int> column_of = assign_columns(azimuths, lidar.columns);

    const double late = row.time_offset / lidar.sweep_s;
    const auto put_direction = [&](int column, double azimuth) {
      const std::size_t ray = r * columns + static_cast<std::size_t>(column);
      sweep.rays.azimuth[ray] = static_cast<float>(azimuth);
      sweep.rays.time_fraction[ray] = static_cast<float>((kPi - azimuth) / (2.0 * kPi) + late);
    };
    // The sweep's ends, half a step outside the first and the last column, close the outer gaps.
    double before_column = -0.5;
    double before_azimuth = kPi;
    for (std::size_t i = 0; i <= points.size(); ++i) {
      const bool at_end = i == points.size();
      const double next_column = at_end ? lidar.columns - 0.5 : column_of[i];
      const double next_azimuth = at_end ? -kPi : azimuths[i];
      for (int c = static_cast<int>(std::floor(before_column)) + 1; c < next_column; ++c) {
        const double u = (c - before_column) / (next_column - before_column);
        put_direction(c, before_azimuth + u * (next_azimuth - before_azimuth));
      }
      before_column = next_column;
      before_azimuth = next_azimuth;
      if (at_end) break;
      const Eigen::Vector3d& p = points[i].position;
      const std::size_t ray = r * columns + static_cast<std::size_t>(column_of[i]);
      put_direction(column_of[i], azimuths[i]);
      sweep.rays.elevation[ray] = static_cast<float>(elevation_from(row, p));
      sweep.range[ray] = static_cast<float>((p - lidar.origin(static_cast<int>(r), azimuths[i])).norm());
      sweep.intensity[ray] = static_cast<float>(points[i].reflectance);
    }
  }
  return sweep;
}

}  // namespace simuli::kitti
