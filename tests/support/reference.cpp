// Implements particles, sensors and rays of tests/support/reference.hpp.
#include "tests/support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/core/base/error.hpp"

namespace simuli::reference {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Ray camera_ray(const Sensor& sensor, int column, int row) {
  const Camera& camera = sensor.camera;
  Ray ray;
  ray.x = column + 0.5;
  ray.y = row + 0.5;
  const Pose scene_from_camera = sensor.scene_from_sensor(exposure_time(camera, {ray.x, ray.y}));
  const Vector3d d_camera = camera_direction(camera, {ray.x, ray.y});
  ray.origin = scene_from_camera.translation;
  ray.direction = (scene_from_camera.rotation * d_camera).normalized();
  return ray;
}

Ray lidar_ray(const Sensor& sensor, int row, std::size_t index) {
  const LidarRow& beam = sensor.lidar.rows[static_cast<std::size_t>(row)];
  const double azimuth = sensor.lidar_rays.azimuth[index];
  const double elevation = sensor.lidar_rays.elevation[index];
  const Pose scene_from_lidar = sensor.scene_from_sensor(sensor.lidar_rays.time_fraction[index]);
  const Vector3d outwards(std::cos(azimuth), std::sin(azimuth), 0.0);
  const Vector3d to_the_left(-std::sin(azimuth), std::cos(azimuth), 0.0);
  const Vector3d o_lidar = beam.radial_offset * outwards + beam.horizontal_offset * to_the_left +
                           Vector3d(0.0, 0.0, beam.vertical_offset);
  const Vector3d d_lidar(
      std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  Ray ray;
  ray.origin = scene_from_lidar.rotation * o_lidar + scene_from_lidar.translation;
  ray.direction = (scene_from_lidar.rotation * d_lidar).normalized();
  ray.x =
      spin_angle(sensor.lidar, azimuth, sensor.lidar_rays.time_fraction[index] * sensor.lidar.azimuth_span);
  ray.y = beam.elevation;
  return ray;
}

}  // namespace

Particles::Particles(const GaussianSet& set)
    : kind(set.kind), sh_degree(set.sh_degree), params(set.params.cast<double>()) {}

Sensor Sensor::of(const Camera& camera,
                  const Pose& scene_from_sensor_start,
                  const Pose& scene_from_sensor_end) {
  Sensor sensor;
  sensor.kind = SetKind::kCamera;
  sensor.camera = camera;
  sensor.scene_from_sensor_start = scene_from_sensor_start;
  sensor.scene_from_sensor_end = scene_from_sensor_end;
  return sensor;
}

Sensor Sensor::of(const Lidar& lidar,
                  const LidarRays& rays,
                  const Pose& scene_from_sensor_start,
                  const Pose& scene_from_sensor_end) {
  const std::size_t count = lidar.rows.size() * static_cast<std::size_t>(rays.columns);
  const bool sizes_agree = rays.rows == static_cast<int>(lidar.rows.size()) && rays.azimuth.size() == count &&
                           rays.elevation.size() == count && rays.time_fraction.size() == count;
  if (!sizes_agree) throw Error(ErrorKind::kInternal, "rays of another size than the LiDAR's rows");
  Sensor sensor;
  sensor.kind = SetKind::kLidar;
  sensor.lidar = lidar;
  sensor.lidar_rays = rays;
  sensor.scene_from_sensor_start = scene_from_sensor_start;
  sensor.scene_from_sensor_end = scene_from_sensor_end;
  return sensor;
}

bool Sensor::moves() const {
  return scene_from_sensor_start.translation != scene_from_sensor_end.translation ||
         scene_from_sensor_start.rotation.coeffs() != scene_from_sensor_end.rotation.coeffs();
}

Pose Sensor::scene_from_sensor(double u) const {
  const Eigen::Vector4d a = scene_from_sensor_start.rotation.coeffs().normalized();
  Eigen::Vector4d b = scene_from_sensor_end.rotation.coeffs().normalized();
  if (a.dot(b) < 0.0) b = -b;  // the same rotation, on the shorter arc
  // The angle from sum and difference: acos of the dot product has no digits left for small angles.
  const double angle = 2.0 * std::atan2((a - b).norm(), (a + b).norm());
  constexpr double kStraight_rad = 1e-9;  // below it the arc and its chord agree to 1e-18
  Eigen::Vector4d q = (1.0 - u) * a + u * b;
  if (angle > kStraight_rad) q = std::sin((1.0 - u) * angle) * a + std::sin(u * angle) * b;
  q.normalize();
  Pose scene_from_sensor_at_u;
  scene_from_sensor_at_u.rotation.coeffs() = q;
  scene_from_sensor_at_u.translation =
      (1.0 - u) * scene_from_sensor_start.translation + u * scene_from_sensor_end.translation;
  return scene_from_sensor_at_u;
}

double wrapped(double angle) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double turned = angle - kTurn * std::floor((angle + std::numbers::pi) / kTurn);
  return turned < std::numbers::pi ? turned : turned - kTurn;
}

double exposure_time(const Camera& camera, const Vector2d& pixel) {
  double fraction = 0.5;
  switch (camera.shutter) {
    case ShutterKind::kGlobal:
      break;
    case ShutterKind::kTopToBottom:
      fraction = pixel.y() / camera.height;
      break;
    case ShutterKind::kBottomToTop:
      fraction = 1.0 - pixel.y() / camera.height;
      break;
    case ShutterKind::kLeftToRight:
      fraction = pixel.x() / camera.width;
      break;
    case ShutterKind::kRightToLeft:
      fraction = 1.0 - pixel.x() / camera.width;
      break;
  }
  return std::clamp(fraction, 0.0, 1.0);
}

double spin_angle(const Lidar& lidar, double azimuth, double anchor) {
  const double spin = lidar.spin == SpinDirection::kCounterClockwise ? 1.0 : -1.0;
  const double start = lidar.azimuth_first - spin * 0.5 * lidar.azimuth_span / lidar.columns;
  return anchor + wrapped(spin * (azimuth - start) - anchor);
}

Eigen::VectorXd sh_basis(int degree, const Vector3d& direction) {
  if (degree < 0 || degree > 3) throw Error(ErrorKind::kInternal, "SH degree outside 0..3");
  const double x = direction.x();
  const double y = direction.y();
  const double z = direction.z();
  Eigen::VectorXd basis((degree + 1) * (degree + 1));
  basis[0] = 0.28209479177387814;
  if (degree >= 1) {
    basis[1] = -0.4886025119029199 * y;
    basis[2] = 0.4886025119029199 * z;
    basis[3] = -0.4886025119029199 * x;
  }
  if (degree >= 2) {
    basis[4] = 1.0925484305920792 * x * y;
    basis[5] = -1.0925484305920792 * y * z;
    basis[6] = 0.31539156525252005 * (2.0 * z * z - x * x - y * y);
    basis[7] = -1.0925484305920792 * x * z;
    basis[8] = 0.5462742152960396 * (x * x - y * y);
  }
  if (degree >= 3) {
    basis[9] = -0.5900435899266435 * y * (3.0 * x * x - y * y);
    basis[10] = 2.890611442640554 * x * y * z;
    basis[11] = -0.4570457994644658 * y * (4.0 * z * z - x * x - y * y);
    basis[12] = 0.3731763325901154 * z * (2.0 * z * z - 3.0 * x * x - 3.0 * y * y);
    basis[13] = -0.4570457994644658 * x * (4.0 * z * z - x * x - y * y);
    basis[14] = 1.445305721320277 * z * (x * x - y * y);
    basis[15] = -0.5900435899266435 * x * (x * x - 3.0 * y * y);
  }
  return basis;
}

std::vector<Ray> rays(const Sensor& sensor) {
  std::vector<Ray> all;
  if (sensor.kind == SetKind::kCamera) {
    for (int row = 0; row < sensor.camera.height; ++row) {
      for (int column = 0; column < sensor.camera.width; ++column) {
        all.push_back(camera_ray(sensor, column, row));
      }
    }
    return all;
  }
  for (int row = 0; row < sensor.lidar_rays.rows; ++row) {
    for (int column = 0; column < sensor.lidar_rays.columns; ++column) {
      all.push_back(lidar_ray(sensor, row, all.size()));
    }
  }
  return all;
}

}  // namespace simuli::reference
