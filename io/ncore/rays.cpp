#include "io/ncore/rays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "host/core/base/error.hpp"

namespace simuli::ncore {
namespace {

constexpr std::size_t kMostElements = 65536;  // per axis
constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

using Seen = std::array<float, 3>;

Seen single(const Eigen::Vector3d& direction) {
  return {static_cast<float>(direction.x()),
          static_cast<float>(direction.y()),
          static_cast<float>(direction.z())};
}

Eigen::Vector3d nominal_direction(const LidarRays& rays, std::size_t i) {
  return Lidar::direction(rays.azimuth[i], rays.elevation[i]);
}

/// End point of a ray of `range` metres, relative to the sensor's origin.
struct End {
  Seen direction;
  float distance = 0.0F;
};
End end_of(const LidarModel& model, const LidarRays& rays, std::size_t i, float range) {
  const Eigen::Vector3d end = ray_origin(model, rays, i) + range * nominal_direction(rays, i);
  return {single(end.normalized()), static_cast<float>(end.norm())};
}

std::uint64_t stamp(float fraction, const FrameTime& time) {
  const double duration = static_cast<double>(time.end_us - time.start_us);
  const double after = std::clamp(std::round(fraction * duration), 0.0, duration);
  return time.start_us + static_cast<std::uint64_t>(after);
}

float fraction_of(std::uint64_t stamp_us, const FrameTime& time) {
  const double duration = static_cast<double>(time.end_us - time.start_us);
  const double after = static_cast<double>(static_cast<std::int64_t>(stamp_us - time.start_us));
  return duration > 0.0 ? static_cast<float>(std::clamp(after / duration, -1.0, 2.0)) : 0.0F;
}

/// Returns the range along the ray at which the distance from the sensor's origin is `distance`; 0 without a
/// solution.
double range_at(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double distance) {
  const double along = origin.dot(direction);
  const double square = along * along + distance * distance - origin.squaredNorm();
  return square > 0.0 ? std::sqrt(square) - along : 0.0;
}

/// Converts one ray of a bundle to a ray of a sweep.
class Ray {
 public:
  Ray(const LidarModel& model, Sweep& sweep, std::size_t i) : model_(model), sweep_(sweep), i_(i) {}

  void look(const Seen& seen) {
    if (seen == single(nominal_direction(sweep_.rays, i_))) return;
    set_angles({seen[0], seen[1], seen[2]});
  }
  void end(const Seen& seen, float distance, float intensity) {
    sweep_.intensity[i_] = intensity;
    const Eigen::Vector3d origin = ray_origin(model_, sweep_.rays, i_),
                          ahead = nominal_direction(sweep_.rays, i_);
    const auto range = static_cast<float>(range_at(origin, ahead, distance));
    for (const float next : {range, std::nextafter(range, 0.0F), std::nextafter(range, 1e9F)}) {
      const End end = end_of(model_, sweep_.rays, i_, next);
      if (!(next > 0.0F) || end.direction != seen || end.distance != distance) continue;
      sweep_.range[i_] = next;
      return;
    }
    measured(distance * Eigen::Vector3d(seen[0], seen[1], seen[2]).normalized());
  }

 private:
  /// Computes the angles of the point from the ray's own origin. The origin depends on the angles, but moves
  /// only centimetres.
  void measured(const Eigen::Vector3d& place) {
    constexpr int kSteps = 6;
    Eigen::Vector3d from_origin = place;
    for (int step = 0; step < kSteps; ++step) {
      set_angles(from_origin);
      from_origin = place - ray_origin(model_, sweep_.rays, i_);
    }
    sweep_.range[i_] = static_cast<float>(from_origin.norm());
    if (sweep_.range[i_] == 0.0F) sweep_.intensity[i_] = 0.0F;
  }
  void set_angles(const Eigen::Vector3d& direction) {
    sweep_.rays.azimuth[i_] = static_cast<float>(std::atan2(direction.y(), direction.x()));
    sweep_.rays.elevation[i_] = static_cast<float>(std::atan2(direction.z(), direction.head<2>().norm()));
  }

  const LidarModel& model_;
  Sweep& sweep_;
  std::size_t i_;
};

std::array<float, 4> values_of(const Sweep& sweep, std::size_t i) {
  return {sweep.rays.azimuth[i], sweep.rays.elevation[i], sweep.rays.time_fraction[i], sweep.range[i]};
}

}  // namespace

RayGrid::RayGrid(const LidarModel& model) : model_(model), nominal_(nominal_rays(model)) {
  const std::size_t rows = row_count(model);
  has_elements_ = std::holds_alternative<Lidar>(model) && rows <= kMostElements &&
                  ray_count(model) / rows <= kMostElements;
}

RayBundle RayGrid::bundle(const Sweep& sweep, const FrameTime& time) const {
  const std::size_t count = sweep.range.size(), columns = count / row_count(model_);
  RayBundle out;
  out.direction.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_return = sweep.range[i] > 0.0F;
    End end{single(nominal_direction(sweep.rays, i)), kNothing};
    if (is_return) end = end_of(model_, sweep.rays, i, sweep.range[i]);
    out.direction.insert(out.direction.end(), end.direction.begin(), end.direction.end());
    out.distance.push_back(end.distance);
    out.intensity.push_back(is_return ? sweep.intensity[i] : kNothing);
    out.timestamp_us.push_back(stamp(sweep.rays.time_fraction[i], time));
    if (!has_elements_) continue;
    out.element.push_back(static_cast<std::uint16_t>(i / columns));
    out.element.push_back(static_cast<std::uint16_t>(i % columns));
  }
  return out;
}

Sweep RayGrid::sweep(const RayBundle& bundle,
                     const FrameTime& time,
                     const std::string& file,
                     std::size_t& twice) const {
  const std::size_t count = ray_count(model_), rows = row_count(model_), columns = count / rows;
  Sweep out{nominal_, std::vector<float>(count, 0.0F), std::vector<float>(count, 0.0F)};
  if (bundle.element.empty() && bundle.count() != count) {
    throw_input_error(file,
                      "ray_bundle",
                      fmt::format("{} rays without model_element", bundle.count()),
                      fmt::format("model_element, or all {} rays of the sensor", count));
  }
  std::vector<bool> is_set(count, false);
  for (std::size_t n = 0; n < bundle.count(); ++n) {
    std::size_t i = n;
    if (!bundle.element.empty()) {
      const std::size_t row = bundle.element[2 * n], column = bundle.element[2 * n + 1];
      if (row >= rows || column >= columns) {
        throw_input_error(file,
                          fmt::format("model_element[{}]", n),
                          fmt::format("row {}, column {}", row, column),
                          fmt::format("below {} and {}", rows, columns));
      }
      i = row * columns + column;
    }
    if (is_set[i]) {
      ++twice;
      continue;
    }
    is_set[i] = true;
    if (bundle.timestamp_us[n] != stamp(nominal_.time_fraction[i], time))
      out.rays.time_fraction[i] = fraction_of(bundle.timestamp_us[n], time);
    const Seen seen{bundle.direction[3 * n], bundle.direction[3 * n + 1], bundle.direction[3 * n + 2]};
    Ray ray(model_, out, i);
    if (bundle.distance[n] > 0.0F) {
      ray.end(seen, bundle.distance[n], bundle.intensity[n]);
    } else {
      ray.look(seen);
    }
  }
  return out;
}

Exact RayGrid::lost(const Sweep& sweep, const RayBundle& bundle, const FrameTime& time) const {
  std::size_t twice = 0;
  const Sweep again = this->sweep(bundle, time, "", twice);
  Exact out;
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    const std::array<float, 4> values = values_of(sweep, i);
    if (values == values_of(again, i)) continue;
    out.ray.push_back(static_cast<std::uint32_t>(i));
    out.values.insert(out.values.end(), values.begin(), values.end());
  }
  return out;
}

void RayGrid::restore(const Exact& exact, Sweep& sweep) const {
  // Tolerances: single precision of a direction, a microsecond of a sweep, and the range error relative to the
  // angular error.
  constexpr float kAngle_rad = 1e-5F, kTime = 1e-3F, kRange = 1e-4F;
  constexpr float kTurn = 6.2831853F;
  for (std::size_t n = 0; n < exact.ray.size(); ++n) {
    const std::size_t i = exact.ray[n];
    if (i >= sweep.range.size()) continue;
    const float* const now = exact.values.data() + 4 * n;
    const std::array<float, 4> before = values_of(sweep, i);
    const bool is_same = std::abs(std::remainder(now[0] - before[0], kTurn)) <= kAngle_rad &&
                         std::abs(now[1] - before[1]) <= kAngle_rad &&
                         (now[3] > 0.0F) == (before[3] > 0.0F) &&
                         std::abs(now[3] - before[3]) <= kRange * (1.0F + before[3]) &&
                         // Times outside the frame were clamped.
                         std::abs(std::clamp(now[2], 0.0F, 1.0F) - before[2]) <= kTime;
    if (!is_same) continue;
    sweep.rays.azimuth[i] = now[0];
    sweep.rays.elevation[i] = now[1];
    sweep.rays.time_fraction[i] = now[2];
    sweep.range[i] = now[3];
  }
}

}  // namespace simuli::ncore
