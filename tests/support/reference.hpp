#pragma once
// Reference of the forward pass: sequential, double precision, without tiles and culling. It defines the
// results of the kernels and shares no mathematics with them; host/core/scene and host/core/sensors only
// provide input types. Slow: for hundreds of particles and rays.
//
// Frames: `scene` is the world shifted to Scene::origin, `sensor` the camera or LiDAR frame.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/gaussians.hpp"
#include "host/core/scene/ray_drop.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar.hpp"

namespace simuli::reference {

constexpr double kCameraNear_m = 0.01;  // z_min: nearer points are invisible

struct Options {
  double alpha_cut = 1.0 / 255.0;           // smaller contributions are omitted
  double transmittance_cut = 1e-4;          // a ray ends below this transmittance
  double filter_variance_px2 = 1.0 / 12.0;  // camera footprint filter: variance of a square pixel
  int shutter_iterations = 4;               // iterations for the own time of a sigma point of a moving sensor
  bool ignore_box = false;                  // the response is not clipped to the unscented box
  bool per_ray_order = false;               // order by tau of each ray, not by particle range
  bool per_ray_features = false;            // SH along each ray, not towards the particle's centre
};

/// A GaussianSet in double, with the same order of parameters (ParamRow); finite differences perturb it
/// directly.
struct Particles {
  SetKind kind = SetKind::kCamera;
  int sh_degree = 0;
  Eigen::MatrixXd params;  // [N, param_rows(sh_degree)]

  Particles() = default;
  explicit Particles(const GaussianSet& set);
  [[nodiscard]] Eigen::Index size() const { return params.rows(); }
};

/// A camera or a LiDAR sweep with its poses at the start (u = 0) and the end (u = 1) of the frame.
struct Sensor {
  SetKind kind = SetKind::kCamera;
  Camera camera;         // kind kCamera
  Lidar lidar;           // kind kLidar
  LidarRays lidar_rays;  // kind kLidar
  Pose scene_from_sensor_start;
  Pose scene_from_sensor_end;

  static Sensor of(const Camera& camera,
                   const Pose& scene_from_sensor_start,
                   const Pose& scene_from_sensor_end);
  static Sensor of(const Lidar& lidar,
                   const LidarRays& rays,
                   const Pose& scene_from_sensor_start,
                   const Pose& scene_from_sensor_end);

  /// Whether the two poses differ in any bit.
  [[nodiscard]] bool moves() const;
  /// Slerp of the rotation along the shorter arc, lerp of the centre.
  [[nodiscard]] Pose scene_from_sensor(double u) const;
};

/// One ray in the scene frame at its own time, with its position in sensor coordinates.
struct Ray {
  Eigen::Vector3d origin;     // m
  Eigen::Vector3d direction;  // unit
  double x = 0.0;  // camera: pixel; LiDAR: spin angle since the start of the sweep, rad, unrolled by time
  double y = 0.0;  // camera: pixel; LiDAR: nominal elevation of the beam, rad
};

/// A projected particle: the inputs of render() and intermediate results.
struct Footprint {
  bool visible = false;   // false: invisible (opacity <= alpha_cut, or behind the camera)
  bool fallback = false;  // the box is unbounded: the unscented transform is not valid
  Eigen::Vector3d feature = Eigen::Vector3d::Zero();
  double opacity = 0.0;                                      // sigma
  double range = 0.0;                                        // m, from the sensor centre at mid frame
  float range_key = 0.0F;                                    // sort key: `range` in single precision
  double filter_variance = 0.0;                              // m^2, a of METHOD section 8
  Eigen::Vector3d filtered_scale = Eigen::Vector3d::Zero();  // m, s_hat
  Eigen::Matrix3d scene_from_particle = Eigen::Matrix3d::Identity();  // R
  double extent = 0.0;                                                // k = sqrt(2 ln(sigma / alpha_cut))
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();  // m, pixels or rad (spin angle, elevation)
  double other_x = 0.0;  // LiDAR: the position one revolution later or earlier; a ray may be in either box
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of the seven sigma points; zero in the fallback
  Eigen::Vector2d half_width = Eigen::Vector2d::Zero();  // of the box, with all margins
};

struct RayResult {
  Eigen::Vector3d feature = Eigen::Vector3d::Zero();
  double transmittance = 1.0;
  double distance = 0.0;         // m, tau at which the transmittance reaches 0.5; 0: never
  double median_distance = 0.0;  // m, tau where the transmittance falls to 0.5 or below; 0: never
  int contributors = 0;
  /// Smallest distance of any decision of the ray from its threshold, relative to the threshold: inclusion by
  /// alpha, box and tau, order of keys, early termination. A single-precision implementation may decide
  /// differently if the margin is as small as its rounding.
  double margin = 0.0;
  double median_margin = 0.0;  // smallest |transmittance - 0.5| after any contributor
};

/// Returns ln(p / (1 - p)) of the ray drop probability p of a LiDAR ray.
[[nodiscard]] double drop_logit(const RayDrop::Parameters& parameters, const RayResult& ray);

/// Real spherical harmonics up to `degree` (0..3) in the order and signs of 3DGS: [(degree + 1)^2].
[[nodiscard]] Eigen::VectorXd sh_basis(int degree, const Eigen::Vector3d& direction);

/// Rays in row-major order: pixels of the picture, or rows x columns of the sweep.
[[nodiscard]] std::vector<Ray> rays(const Sensor& sensor);

/// Returns the features of particle i in the unit direction `view` from the sensor.
[[nodiscard]] Eigen::Vector3d feature_of(const Particles& particles,
                                         Eigen::Index i,
                                         const Eigen::Vector3d& view);

/// Returns one footprint per particle, in the order of the set. Throws Error{kInternal} if the kinds of set
/// and sensor differ, Error{kNumeric} for a quaternion of zero norm.
[[nodiscard]] std::vector<Footprint> project(const Particles& particles,
                                             const Sensor& sensor,
                                             const Options& options = {});

/// Blends front to back: one result per ray. `background` is in the channels of the set.
[[nodiscard]] std::vector<RayResult> render(const Particles& particles,
                                            const Sensor& sensor,
                                            const std::vector<Ray>& rays,
                                            const std::vector<Footprint>& footprints,
                                            const Options& options,
                                            const Eigen::Vector3d& background);

/// Calls rays(), project() and render().
[[nodiscard]] std::vector<RayResult> render(const Particles& particles,
                                            const Sensor& sensor,
                                            const Options& options,
                                            const Eigen::Vector3d& background);

/// Computes mean and covariance of `project_point` over a Gaussian with the seven sigma points (offsets from
/// the projected mean; `wrap_x` wraps their x to [-pi, pi)). Returns false if a point cannot be projected;
/// `any_valid` is then true if another point could. Public for tests.
struct SigmaResult {
  bool all_valid = false;
  bool any_valid = false;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};
template <class ProjectPoint>
[[nodiscard]] SigmaResult unscented(const Eigen::Vector3d& mean,
                                    const Eigen::Matrix3d& scene_from_particle,
                                    const Eigen::Vector3d& scale,
                                    bool wrap_x,
                                    ProjectPoint&& project_point);

/// Computes the pixel of a point in the camera frame; returns false without one. Lenses: pinhole,
/// opencv_fisheye (with a radius that increases up to its max_angle_rad) and equirectangular, whose x is not
/// wrapped: only its rays, blended with ignore_box, are a reference.
[[nodiscard]] bool camera_image(const Camera& camera,
                                const Eigen::Vector3d& p_camera,
                                Eigen::Vector2d& pixel);
/// Direction through a pixel, not normalised; zero where there is none.
/// Returns squared pixels per solid angle at the axis.
[[nodiscard]] double px2_per_sr(const Camera& camera);
[[nodiscard]] Eigen::Vector3d camera_direction(const Camera& camera, const Eigen::Vector2d& pixel);

/// Returns `angle` in [-pi, pi).
[[nodiscard]] double wrapped(double angle);

/// Returns the share of the frame at which the pixel is exposed, in [0,1] also for pixels outside the
/// picture.
[[nodiscard]] double exposure_time(const Camera& camera, const Eigen::Vector2d& pixel);

/// Returns the spin angle since the start of the sweep (half a column before the first) of the direction
/// `azimuth`, in the revolution nearest to `anchor`.
[[nodiscard]] double spin_angle(const Lidar& lidar, double azimuth, double anchor);

// ---- implementation of the template -------------------------------------------------------------------

template <class ProjectPoint>
SigmaResult unscented(const Eigen::Vector3d& mean,
                      const Eigen::Matrix3d& scene_from_particle,
                      const Eigen::Vector3d& scale,
                      bool wrap_x,
                      ProjectPoint&& project_point) {
  // n = 3, alpha = 1, beta = 2, kappa = 0: lambda = 0, so the centre has weight 0 in the mean and 1 - alpha^2
  // + beta = 2 in the covariance.
  constexpr double kSpread = 1.7320508075688772;  // sqrt(n + lambda)
  constexpr double kWeight = 1.0 / 6.0;           // 1 / (2 (n + lambda))
  constexpr double kCentreCovarianceWeight = 2.0;

  SigmaResult result;
  Eigen::Vector2d centre;
  const bool centre_valid = project_point(mean, centre);
  result.all_valid = centre_valid;
  result.any_valid = centre_valid;
  Eigen::Matrix<double, 2, 6> offsets;
  for (int i = 0; i < 6; ++i) {
    const int axis = i / 2;
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    const Eigen::Vector3d point = mean + sign * kSpread * scale[axis] * scene_from_particle.col(axis);
    Eigen::Vector2d projected;
    const bool valid = project_point(point, projected);
    result.all_valid = result.all_valid && valid;
    result.any_valid = result.any_valid || valid;
    if (!centre_valid || !valid) continue;
    offsets.col(i) = projected - centre;
    if (wrap_x) offsets(0, i) = wrapped(offsets(0, i));
  }
  if (!result.all_valid) return result;
  const Eigen::Vector2d mean_offset = kWeight * offsets.rowwise().sum();
  result.mean = centre + mean_offset;
  result.covariance = kCentreCovarianceWeight * mean_offset * mean_offset.transpose();
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector2d from_mean = offsets.col(i) - mean_offset;
    result.covariance += kWeight * from_mean * from_mean.transpose();
  }
  return result;
}

}  // namespace simuli::reference
