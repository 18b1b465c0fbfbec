#include "host/sensors/lidar_locate.hpp"

#include <algorithm>
#include <cmath>

#include "host/base/angles.hpp"

namespace simuli {
namespace {

constexpr int kTimeSamples = 64;          // of a sweep, to begin with
constexpr int kSubdivisions = 12;         // of those intervals that may hold a crossing
constexpr double kTimeTolerance = 1e-12;  // of the sweep

/// The hit with a column that may lie outside the sweep: turned back by at most half a turn from its middle.
std::optional<LidarHit> locate_unbounded(const Lidar& lidar, int row, const Eigen::Vector3d& p_sensor) {
  const LidarRow& beam = lidar.rows[static_cast<std::size_t>(row)];
  const double flat = std::hypot(p_sensor.x(), p_sensor.y());
  if (!(flat > std::abs(beam.horizontal_offset))) return std::nullopt;
  LidarHit hit;
  hit.row = row;
  // Seen from above the ray is a line that passes the spin axis at the horizontal offset.
  hit.azimuth = std::atan2(p_sensor.y(), p_sensor.x()) - std::asin(beam.horizontal_offset / flat);
  const double along =
      std::sqrt((flat - beam.horizontal_offset) * (flat + beam.horizontal_offset)) - beam.radial_offset;
  if (!(along > 0.0)) return std::nullopt;
  const double height = p_sensor.z() - beam.vertical_offset;
  hit.elevation_error = std::atan2(height, along) - beam.elevation;
  hit.range = std::hypot(along, height);

  const double step = lidar.azimuth_span / lidar.columns;
  const double middle = (lidar.azimuth_span - step) / 2.0;
  const double turned = (hit.azimuth - lidar.azimuth_first - beam.azimuth_offset) * lidar.spin_sign();
  hit.column = (middle + std::remainder(turned - middle, 2.0 * kPi)) / step;
  hit.time_fraction = (hit.column + 0.5) / lidar.columns;
  hit.time_fraction += beam.time_offset / lidar.sweep_s;
  return hit;
}

bool in_sweep(const Lidar& lidar, const LidarHit& hit) {
  constexpr double kRounding = 1e-9;  // columns: a full turn has no gap at its cut
  return hit.column >= -0.5 - kRounding && hit.column <= lidar.columns - 0.5 + kRounding;
}

}  // namespace

int LidarHit::nearest_column(const Lidar& lidar) const {
  const int nearest = static_cast<int>(std::lround(column));
  return nearest < 0 ? nearest + lidar.columns : nearest % lidar.columns;
}

std::optional<LidarHit> locate_in_row(const Lidar& lidar, int row, const Eigen::Vector3d& p_sensor) {
  const auto hit = locate_unbounded(lidar, row, p_sensor);
  return hit && in_sweep(lidar, *hit) ? hit : std::nullopt;
}

std::optional<LidarHit> locate(const Lidar& lidar, const Eigen::Vector3d& p_sensor) {
  const double step = lidar.azimuth_span / lidar.columns;
  std::optional<LidarHit> best;
  double smallest = 0.0;
  for (int row = 0; row < lidar.row_count(); ++row) {
    const auto hit = locate_in_row(lidar, row, p_sensor);
    if (!hit) continue;
    const double elevation = lidar.rows[static_cast<std::size_t>(row)].elevation;
    const double sideways = (hit->column - std::round(hit->column)) * step * std::cos(elevation);
    const double angle = std::hypot(sideways, hit->elevation_error);
    if (!best || angle < smallest) {
      best = hit;
      smallest = angle;
    }
  }
  return best;
}

namespace {

/// The search for the times at which a row passes the azimuth of a point.
class MovingSearch {
 public:
  MovingSearch(const Lidar& lidar,
               int row,
               const Eigen::Vector3d& p_world,
               const Pose& world_from_sensor_start,
               const Pose& world_from_sensor_end)
      : lidar_(lidar),
        row_(row),
        p_world_(p_world),
        start_(world_from_sensor_start),
        end_(world_from_sensor_end),
        turn_(2.0 * kPi / lidar.azimuth_span) {}

  std::vector<LidarHit> run() {
    const double first = lidar_.time_fraction(row_, 0) - 0.5 / lidar_.columns;
    Sample before = sample(first);
    for (int i = 1; i <= kTimeSamples; ++i) {
      const Sample after = sample(first + static_cast<double>(i) / kTimeSamples);
      search(before, after, kSubdivisions);
      before = after;
    }
    return hits_;
  }

 private:
  struct Sample {
    double time = 0.0;
    double late = 0.0;  // the firing at the point's azimuth comes this much later, within half a turn
    std::optional<LidarHit> hit;
  };

  [[nodiscard]] Sample sample(double time) const {
    const Pose world_from_sensor = interpolate(start_, end_, time);
    Sample s;
    s.time = time;
    s.hit = locate_unbounded(lidar_, row_, world_from_sensor.inverse() * p_world_);
    if (s.hit) s.late = std::remainder(s.hit->time_fraction - time, turn_);
    return s;
  }

  void search(const Sample& before, const Sample& after, int subdivisions) {
    if (!before.hit || !after.hit) return;
    // Where the point moves about as fast as the beam turns, two crossings may hide between two samples.
    const double change = std::abs(std::remainder(after.late - before.late, turn_));
    const double nearest = std::min(std::abs(before.late), std::abs(after.late));
    if (subdivisions > 0 && nearest < 2.0 * (after.time - before.time) + change) {
      const Sample middle = sample(0.5 * (before.time + after.time));
      search(before, middle, subdivisions - 1);
      search(middle, after, subdivisions - 1);
      return;
    }
    // A jump by about a turn is the far side of the circle, not a crossing.
    if ((before.late > 0.0) == (after.late > 0.0) || std::abs(before.late - after.late) >= turn_ / 2.0)
      return;
    add_crossing(before, after);
  }

  void add_crossing(Sample low, Sample high) {
    while (high.time - low.time > kTimeTolerance) {
      const Sample middle = sample(0.5 * (low.time + high.time));
      if (!middle.hit) return;
      ((middle.late > 0.0) == (low.late > 0.0) ? low : high) = middle;
    }
    if (!(std::abs(low.late) < 1.0 / lidar_.columns)) return;  // the sensor went through the point
    LidarHit hit = *low.hit;
    // The column may be a turn away from the firing at this time: the cut of the sweep.
    hit.column += (low.time + low.late - hit.time_fraction) * lidar_.columns;
    hit.time_fraction = low.time + low.late;
    if (in_sweep(lidar_, hit)) hits_.push_back(hit);
  }

  const Lidar& lidar_;
  int row_;
  Eigen::Vector3d p_world_;
  Pose start_;
  Pose end_;
  double turn_;  // a full turn as a share of the sweep
  std::vector<LidarHit> hits_;
};

}  // namespace

std::vector<LidarHit> locate_moving(const Lidar& lidar,
                                    int row,
                                    const Eigen::Vector3d& p_world,
                                    const Pose& world_from_sensor_start,
                                    const Pose& world_from_sensor_end) {
  return MovingSearch(lidar, row, p_world, world_from_sensor_start, world_from_sensor_end).run();
}

}  // namespace simuli
