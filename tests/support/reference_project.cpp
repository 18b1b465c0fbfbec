// The projection of tests/support/reference.hpp: particle -> footprint.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/error.hpp"
#include "tests/support/reference.hpp"

namespace simuli::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kCameraNear_m = 0.01;    // z_min
constexpr double kPoleMargin_rad = 0.05;  // a LiDAR particle this close to the spin axis is a ring
constexpr double kSeamMargin_rad = 0.2;
constexpr double kMinLeverRange_m = 1e-3;

/// The point between the rows' origins to which LiDAR azimuth and elevation refer, in the LiDAR frame.
Vector3d reference_origin(const Lidar& lidar) {
  double sum = 0.0;
  for (const LidarRow& row : lidar.rows) sum += row.vertical_offset;
  return {0.0, 0.0, sum / static_cast<double>(lidar.rows.size())};
}

double lever_arm_m(const Lidar& lidar) {
  double low = lidar.rows.front().vertical_offset;
  double high = low;
  double horizontal = 0.0;
  for (const LidarRow& row : lidar.rows) {
    low = std::min(low, row.vertical_offset);
    high = std::max(high, row.vertical_offset);
    horizontal = std::max(horizontal, std::abs(row.horizontal_offset));
  }
  return 0.5 * (high - low) + horizontal;
}

/// The point in the sensor frame at time u; of a LiDAR from its reference origin.
Vector3d in_sensor(const Sensor& sensor, const Vector3d& p_scene, double u) {
  const Pose scene_from_sensor = sensor.scene_from_sensor(u);
  const Vector3d p_sensor =
      scene_from_sensor.rotation.conjugate() * (p_scene - scene_from_sensor.translation);
  return sensor.kind == SetKind::kCamera ? p_sensor : p_sensor - reference_origin(sensor.lidar);
}

/// Pixel, or azimuth and elevation, of the point seen at time u; false when it has none.
bool project_at(const Sensor& sensor, const Vector3d& p_scene, double u, Vector2d& xy) {
  const Vector3d p = in_sensor(sensor, p_scene, u);
  if (sensor.kind == SetKind::kLidar) {
    xy = {std::atan2(p.y(), p.x()), std::atan2(p.z(), std::hypot(p.x(), p.y()))};
    return true;
  }
  return camera_image(sensor.camera, p, xy);
}

/// The same at the time at which the sensor sees the point. A point without a projection at any step of
/// the iteration has none.
bool project_at_own_time(const Sensor& sensor,
                         const Vector3d& p_scene,
                         const Options& options,
                         Vector2d& xy) {
  double u = 0.5;
  if (sensor.moves()) {
    for (int i = 0; i < options.shutter_iterations; ++i) {
      if (!project_at(sensor, p_scene, u, xy)) return false;
      u = sensor.kind == SetKind::kCamera ? exposure_time(sensor.camera, xy)
                                          : firing_time(sensor.lidar, xy.x());
    }
  }
  return project_at(sensor, p_scene, u, xy);
}

double filter_variance_m2(const Sensor& sensor, double range_m, const Options& options) {
  if (sensor.kind == SetKind::kCamera) {
    return options.filter_variance_px2 / (sensor.camera.fx * sensor.camera.fy) * range_m * range_m;
  }
  const double tangent = std::tan(0.5 * sensor.lidar.beam_divergence);
  return sensor.lidar.divergence_variance * tangent * tangent * range_m * range_m;
}

Vector3d feature_of(const Particles& particles, Eigen::Index i, const Vector3d& view) {
  const Eigen::VectorXd basis = sh_basis(particles.sh_degree, view);
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index k = 0; k < basis.size(); ++k) {
    sum += basis[k] * particles.params.block<1, 3>(i, kShRow + 3 * k).transpose();
  }
  // Colours and intensity are biased and not negative; the logits of a LiDAR set are as they stand.
  const int bounded = particles.kind == SetKind::kCamera ? 3 : 1;
  for (int c = 0; c < bounded; ++c) sum[c] = std::max(0.0, 0.5 + sum[c]);
  return sum;
}

void camera_fallback(const Sensor& sensor, const Vector3d& mean, bool any_valid, Footprint& f) {
  f.fallback = true;
  const double radius = f.extent * f.filtered_scale.maxCoeff();
  // Other lenses than the pinhole may see behind the camera.
  const bool reaches = sensor.camera.lens.kind() != LensKind::kPinhole ||
                       in_sensor(sensor, mean, 0.5).z() + radius > kCameraNear_m;
  f.visible = any_valid || reaches;
  f.mean = {0.5 * sensor.camera.width, 0.5 * sensor.camera.height};
  f.half_width = f.mean;
}

/// The ring of all azimuths for a particle around the sensor or about its spin axis; false for others.
bool lidar_fallback(const Vector3d& p_mid, Footprint& f) {
  const double radius = f.extent * f.filtered_scale.maxCoeff();
  const double distance = p_mid.norm();
  const double from_axis = std::hypot(p_mid.x(), p_mid.y());
  const bool around = distance <= radius;
  const bool at_pole = from_axis <= radius + kPoleMargin_rad * std::abs(p_mid.z());
  if (!around && !at_pole) return false;
  f.fallback = true;
  f.mean = {std::atan2(p_mid.y(), p_mid.x()), std::atan2(p_mid.z(), from_axis)};
  f.half_width = {kPi, around ? kPi : std::asin(std::min(1.0, radius / distance))};
  return true;
}

/// What widens a LiDAR box, unscented or fallback: rows that do not start at the reference origin, and
/// motion across the sweep's cut.
void widen_lidar_box(const Sensor& sensor, const Vector3d& mean, Footprint& f) {
  const double lever = lever_arm_m(sensor.lidar);
  f.half_width.array() += lever / std::max(f.range - lever, kMinLeverRange_m);
  if (!sensor.moves()) return;
  const auto angles = [&](double u) {
    Vector2d xy;
    project_at(sensor, mean, u, xy);
    return xy;
  };
  const double from_cut = std::abs(wrapped(angles(0.5).x() - sensor.lidar.azimuth_first));
  if (!(from_cut <= f.half_width.x() + kSeamMargin_rad)) return;
  const Vector2d start = angles(0.0);
  const Vector2d end = angles(1.0);
  f.half_width.x() += std::abs(wrapped(start.x() - end.x()));
  f.half_width.y() += std::abs(start.y() - end.y());
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

  const bool lidar = sensor.kind == SetKind::kLidar;
  if (lidar && lidar_fallback(in_sensor(sensor, mean, 0.5), f)) {
    widen_lidar_box(sensor, mean, f);
    return f;
  }
  const SigmaResult sigma = unscented(
      mean, f.scene_from_particle, f.filtered_scale, lidar, [&](const Vector3d& p_scene, Vector2d& xy) {
        return project_at_own_time(sensor, p_scene, options, xy);
      });
  if (!sigma.all_valid) {
    camera_fallback(sensor, mean, sigma.any_valid, f);
    return f;
  }
  f.mean = sigma.mean;
  f.covariance = sigma.covariance;
  f.half_width = f.extent * sigma.covariance.diagonal().cwiseSqrt();
  if (lidar) widen_lidar_box(sensor, mean, f);
  return f;
}

}  // namespace

std::vector<Footprint> project(const Particles& particles, const Sensor& sensor, const Options& options) {
  if (particles.kind != sensor.kind) throw Error(ErrorKind::kInternal, "set and sensor of different kinds");
  std::vector<Footprint> footprints;
  for (Eigen::Index i = 0; i < particles.size(); ++i) {
    footprints.push_back(footprint_of(particles, i, sensor, options));
  }
  return footprints;
}

}  // namespace simuli::reference
