// Implements the projection of tests/support/reference.hpp: particle -> footprint.
#include <algorithm>
#include <cmath>
#include <utility>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "tests/support/reference.hpp"

namespace simuli::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPoleMargin_rad = 0.05;  // a LiDAR particle this close to the spin axis covers all azimuths
constexpr double kSettled = 1.0 / 32.0;   // convergence of the time, in rows or columns
// limit of the time's rate of change: beyond it there may be several solutions or none
constexpr double kRateMax = 0.75;
constexpr double kNoBound = 1e9;
constexpr double kWidestBox_rad = 1.5;   // half-width above which a box covers all azimuths
constexpr double kAllRound_rad = 100.0;  // half-width of a box over all azimuths
constexpr double kMinLeverRange_m = 1e-3;

/// Returns the reference point of LiDAR azimuth and elevation between the beams' origins, in the LiDAR frame.
Vector3d reference_origin(const Lidar& lidar) {
  double sum = 0.0;
  for (const LidarRow& row : lidar.rows) sum += row.vertical_offset;
  return {0.0, 0.0, sum / static_cast<double>(lidar.rows.size())};
}

double lever_arm_m(const Lidar& lidar) {
  const double middle = reference_origin(lidar).z();
  double vertical = 0.0;
  double horizontal = 0.0;
  for (const LidarRow& row : lidar.rows) {
    vertical = std::max(vertical, std::abs(row.vertical_offset - middle));
    horizontal = std::max(horizontal, std::hypot(row.horizontal_offset, row.radial_offset));
  }
  return vertical + horizontal;
}

/// Returns the point in the sensor frame at time u; for a LiDAR relative to its reference origin.
Vector3d in_sensor(const Sensor& sensor, const Vector3d& p_scene, double u) {
  const Pose scene_from_sensor = sensor.scene_from_sensor(u);
  const Vector3d p_sensor =
      scene_from_sensor.rotation.conjugate() * (p_scene - scene_from_sensor.translation);
  return sensor.kind == SetKind::kCamera ? p_sensor : p_sensor - reference_origin(sensor.lidar);
}

/// Computes the pixel, or spin angle (in the revolution nearest to `anchor`) and elevation, of the point at
/// time u; returns false without one.
bool project_at(const Sensor& sensor, const Vector3d& p_scene, double u, double anchor, Vector2d& xy) {
  const Vector3d p = in_sensor(sensor, p_scene, u);
  if (sensor.kind == SetKind::kLidar) {
    xy = {spin_angle(sensor.lidar, std::atan2(p.y(), p.x()), anchor),
          std::atan2(p.z(), std::hypot(p.x(), p.y()))};
    return true;
  }
  return camera_image(sensor.camera, p, xy);
}

/// Returns the share of the frame at which the sensor measures xy, in [0, 1].
double time_of(const Sensor& sensor, const Vector2d& xy) {
  if (sensor.kind == SetKind::kCamera) return exposure_time(sensor.camera, xy);
  return std::clamp(xy.x() / sensor.lidar.azimuth_span, 0.0, 1.0);
}

/// Returns the share of the frame between consecutive rows or columns.
double time_step(const Sensor& sensor) {
  if (sensor.kind == SetKind::kLidar) return 1.0 / sensor.lidar.columns;
  switch (sensor.camera.shutter) {
    case ShutterKind::kGlobal:
      return 0.0;
    case ShutterKind::kTopToBottom:
    case ShutterKind::kBottomToTop:
      return 1.0 / sensor.camera.height;
    default:
      return 1.0 / sensor.camera.width;
  }
}

/// The same at the time at which the sensor measures the point, starting from time u. Returns false if no
/// such time is found.
bool project_at_own_time(const Sensor& sensor,
                         const Vector3d& p_scene,
                         const Options& options,
                         double anchor,
                         double u,
                         Vector2d& xy) {
  if (!sensor.moves()) return project_at(sensor, p_scene, u, anchor, xy);
  double last_u = u;
  double last_gap = 0.0;
  for (int i = 0; i < options.shutter_iterations; ++i) {
    const bool seen = project_at(sensor, p_scene, u, anchor, xy);
    const double gap = time_of(sensor, xy) - u;
    if (std::abs(gap) <= kSettled * time_step(sensor)) return seen;
    // The secant of gap(u), or the plain step if the secant diverges or is not available.
    const double slope = u != last_u ? (gap - last_gap) / (u - last_u) : 0.0;
    const double step = slope > -2.0 && slope < -0.125 ? -gap / slope : gap;
    last_u = u;
    last_gap = gap;
    u = std::clamp(u + step, 0.0, 1.0);
  }
  return false;
}

/// Returns a bound on the rate of change of a point's measurement time due to sensor motion, for points
/// within `radius` of p_mid (sensor frame at mid frame, for a LiDAR relative to its reference origin).
double shutter_rate(const Sensor& sensor, const Vector3d& p_mid, double radius) {
  const Pose& start = sensor.scene_from_sensor_start;
  const Pose& end = sensor.scene_from_sensor_end;
  const double angle = start.rotation.angularDistance(end.rotation);
  const double step = (end.translation - start.translation).norm();
  const double range = p_mid.norm();
  const double ball = radius + 0.5 * step;
  if (sensor.kind == SetKind::kLidar) {
    const double flat = p_mid.head<2>().norm() - ball - 0.5 * angle * range;
    if (flat <= 1e-3 * range) return kNoBound;
    return (angle * (range + ball) + step) / flat / sensor.lidar.azimuth_span;
  }
  const double per_px = time_step(sensor);
  if (per_px == 0.0) return 0.0;
  if (range - ball <= 1e-3 * range) return kNoBound;
  const double turn = angle + step / (range - ball);
  const double cosine = p_mid.z() / range - ball / std::sqrt(range * range - ball * ball) - 0.5 * angle;
  if (cosine <= 0.1) return kNoBound;
  return per_px * sensor.camera.focal_px() / (cosine * cosine) * turn;
}

/// Returns mean and covariance of the sigma points around the particle's position near `anchor`.
SigmaResult sigma_at(const Sensor& sensor,
                     const Options& options,
                     const Vector3d& mean,
                     const Footprint& f,
                     double anchor,
                     double u) {
  Vector2d centre;
  double point_anchor = anchor;
  double point_u = u;
  if (project_at_own_time(sensor, mean, options, anchor, u, centre)) {
    point_anchor = centre.x();
    point_u = time_of(sensor, centre);
  }
  return unscented(
      mean, f.scene_from_particle, f.filtered_scale, false, [&](const Vector3d& p_scene, Vector2d& xy) {
        // The mean keeps its own anchor.
        if (p_scene == mean) return project_at_own_time(sensor, mean, options, anchor, u, xy);
        return project_at_own_time(sensor, p_scene, options, point_anchor, point_u, xy);
      });
}

double filter_variance_m2(const Sensor& sensor, double range_m, const Options& options) {
  if (sensor.kind == SetKind::kCamera) {
    return options.filter_variance_px2 / px2_per_sr(sensor.camera) * range_m * range_m;
  }
  const double tangent = std::tan(0.5 * sensor.lidar.beam_divergence);
  return sensor.lidar.divergence_variance * tangent * tangent * range_m * range_m;
}

void camera_fallback(const Sensor& sensor, const Vector3d& mean, bool any_valid, Footprint& f) {
  f.fallback = true;
  const double radius = f.extent * f.filtered_scale.maxCoeff();
  // Lenses other than the pinhole may show points behind the camera.
  const bool reaches = sensor.camera.lens.kind() != LensKind::kPinhole || sensor.moves() ||
                       in_sensor(sensor, mean, 0.5).z() + radius > kCameraNear_m;
  f.visible = any_valid || reaches;
  f.mean = {0.5 * sensor.camera.width, 0.5 * sensor.camera.height};
  f.half_width = f.mean;
}

/// Whether a particle surrounds the sensor, is near its spin axis, or passes too fast for one position.
bool lidar_around(const Sensor& sensor, const Vector3d& p_mid, const Footprint& f) {
  const double radius = f.extent * f.filtered_scale.maxCoeff();
  const Vector3d step_m =
      sensor.scene_from_sensor_end.translation - sensor.scene_from_sensor_start.translation;
  const double passed_m = 0.5 * step_m.norm();
  const double from_axis = std::hypot(p_mid.x(), p_mid.y());
  return p_mid.norm() <= radius || from_axis <= radius + kPoleMargin_rad * std::abs(p_mid.z()) + passed_m ||
         (sensor.moves() && shutter_rate(sensor, p_mid, radius) >= kRateMax);
}

/// Returns the smallest and largest spin angle of all rays.
std::pair<double, double> swept(const Sensor& sensor) {
  double first = 1e30;
  double last = -1e30;
  for (std::size_t i = 0; i < sensor.lidar_rays.azimuth.size(); ++i) {
    const double by_time = sensor.lidar_rays.time_fraction[i] * sensor.lidar.azimuth_span;
    const double angle = spin_angle(sensor.lidar, sensor.lidar_rays.azimuth[i], by_time);
    first = std::min(first, angle);
    last = std::max(last, angle);
  }
  return {first, last};
}

/// Returns the maximum difference between a LiDAR ray's time and the time of its spin angle, as a share of
/// the frame.
double time_spread(const Sensor& sensor) {
  constexpr double kFloatTimes = 1e-6;
  double spread = 0.0;
  for (std::size_t i = 0; i < sensor.lidar_rays.azimuth.size(); ++i) {
    const double time = sensor.lidar_rays.time_fraction[i];
    const double angle =
        spin_angle(sensor.lidar, sensor.lidar_rays.azimuth[i], time * sensor.lidar.azimuth_span);
    spread = std::max(spread, std::abs(time - angle / sensor.lidar.azimuth_span));
  }
  return spread > kFloatTimes ? spread : 0.0;
}

/// Returns the motion of the mean's image within that time difference.
Vector2d drift(const Sensor& sensor, const Vector3d& mean, double u) {
  const double spread = sensor.moves() ? time_spread(sensor) : 0.0;
  Vector2d farthest(0.0, 0.0), own, xy;
  project_at(sensor, mean, u, 0.0, own);
  if (spread == 0.0) return farthest;
  double dt = spread;
  for (int round = 0; round < 2; ++round) {
    for (const double at : {u + dt, u - dt}) {
      project_at(sensor, mean, at, own.x(), xy);
      farthest = farthest.cwiseMax((xy - own).cwiseAbs());
    }
    // The drifted spin angle changes the time again: sums that series.
    dt = spread / (1.0 - std::min(farthest.x() / sensor.lidar.azimuth_span / spread, 0.75));
  }
  return farthest;
}

/// A LiDAR may measure a particle at two positions of its unrolled spin angle, about one revolution apart. If
/// both are in the sweep, both boxes have the larger half-width and cover both elevations. All are widened by
/// the offsets of the beams' origins.
void lidar_footprint(const Sensor& sensor, const Options& options, const Vector3d& mean, Footprint& f) {
  const Vector3d p_mid = in_sensor(sensor, mean, 0.5);
  const double azimuth = std::atan2(p_mid.y(), p_mid.x());
  const double here = spin_angle(sensor.lidar, azimuth, kPi);  // in [0, 2 pi)
  const double there = here < kPi ? here + 2.0 * kPi : here - 2.0 * kPi;
  const auto start = [&](double x) { return std::clamp(x / sensor.lidar.azimuth_span, 0.0, 1.0); };
  const SigmaResult one = sigma_at(sensor, options, mean, f, here, start(here));
  const SigmaResult two = sigma_at(sensor, options, mean, f, there, start(there));
  const Vector2d half_one = f.extent * one.covariance.diagonal().cwiseSqrt();
  const Vector2d half_two = f.extent * two.covariance.diagonal().cwiseSqrt();
  const double lever = lever_arm_m(sensor.lidar);
  const double widening = lever / std::max(p_mid.norm() - lever, kMinLeverRange_m);
  const auto [first, last] = swept(sensor);
  const Vector2d drifted = drift(sensor, mean, time_of(sensor, one.mean));
  const double reach = half_two.x() + widening + drifted.x();
  const bool both = two.mean.x() + reach >= first && two.mean.x() - reach <= last;

  double low = one.mean.y() - half_one.y();
  double high = one.mean.y() + half_one.y();
  double half_x = half_one.x();
  if (both) {
    low = std::min(low, two.mean.y() - half_two.y());
    high = std::max(high, two.mean.y() + half_two.y());
    half_x = std::max(half_x, half_two.x());
  }
  half_x += widening + drifted.x();
  if (half_x > kWidestBox_rad) half_x = kAllRound_rad;
  f.fallback = lidar_around(sensor, p_mid, f) || !one.all_valid || !two.all_valid;
  if (f.fallback) {
    half_x = kAllRound_rad;
    low = -kAllRound_rad;
    high = kAllRound_rad;
  }
  f.covariance = one.covariance;
  f.mean = {one.mean.x(), 0.5 * (low + high)};
  f.other_x = both ? two.mean.x() : one.mean.x();
  f.half_width = {half_x, 0.5 * (high - low) + widening + drifted.y()};
}

Footprint footprint_of(const Particles& particles,
                       Eigen::Index i,
                       const Sensor& sensor,
                       const Options& options) {
  const auto row = particles.params.row(i);
  const Vector3d mean = row.segment<3>(kMeanRow).transpose();
  const Vector3d scale = row.segment<3>(kLogScaleRow).array().exp().matrix().transpose();
  const Eigen::Vector4d wxyz = row.segment<4>(kRotationRow).transpose();
  if (!(wxyz.norm() > 0.0)) {
    throw Error(ErrorKind::kNumeric, "particle " + std::to_string(i) + ": quaternion without a direction");
  }
  const Vector3d o_ref = sensor.scene_from_sensor(0.5).translation;
  const Vector3d from_sensor = mean - o_ref;

  Footprint f;
  f.opacity = 1.0 / (1.0 + std::exp(-row[kOpacityRow]));
  f.range = from_sensor.norm();
  f.range_key = static_cast<float>(f.range);
  f.feature = feature_of(particles, i, from_sensor.normalized());
  f.filter_variance = filter_variance_m2(sensor, f.range, options);
  f.filtered_scale = (scale.array().square() + f.filter_variance).sqrt().matrix();
  const Eigen::Vector4d q = wxyz.normalized();
  f.scene_from_particle = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  f.visible = f.opacity > options.alpha_cut;
  if (!f.visible) return f;
  f.extent = std::sqrt(2.0 * std::log(f.opacity / options.alpha_cut));

  if (sensor.kind == SetKind::kLidar) {
    lidar_footprint(sensor, options, mean, f);
    return f;
  }
  const SigmaResult sigma = sigma_at(sensor, options, mean, f, 0.0, 0.5);
  const double radius = f.extent * f.filtered_scale.maxCoeff();
  const bool too_fast =
      sensor.moves() && shutter_rate(sensor, in_sensor(sensor, mean, 0.5), radius) >= kRateMax;
  if (!sigma.all_valid || too_fast) {
    camera_fallback(sensor, mean, sigma.any_valid, f);
    return f;
  }
  f.mean = sigma.mean;
  f.covariance = sigma.covariance;
  f.half_width = f.extent * sigma.covariance.diagonal().cwiseSqrt();
  return f;
}

}  // namespace

Vector3d feature_of(const Particles& particles, Eigen::Index i, const Vector3d& view) {
  const Eigen::VectorXd basis = sh_basis(particles.sh_degree, view);
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index k = 0; k < basis.size(); ++k) {
    sum += basis[k] * particles.params.block<1, 3>(i, kShRow + 3 * k).transpose();
  }
  // Colours and intensity have a bias and are not negative; the logits of a LiDAR set are unchanged.
  const int bounded = particles.kind == SetKind::kCamera ? 3 : 1;
  for (int c = 0; c < bounded; ++c) sum[c] = std::max(0.0, 0.5 + sum[c]);
  return sum;
}

std::vector<Footprint> project(const Particles& particles, const Sensor& sensor, const Options& options) {
  if (particles.kind != sensor.kind) throw Error(ErrorKind::kInternal, "set and sensor of different kinds");
  std::vector<Footprint> footprints;
  for (Eigen::Index i = 0; i < particles.size(); ++i) {
    footprints.push_back(footprint_of(particles, i, sensor, options));
  }
  return footprints;
}

}  // namespace simuli::reference
