#pragma once
// Seeded random scenes and small sensors for tests. The same seed gives the same bits everywhere: the
// standard library's distributions are not used because they differ between its versions.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <random>
#include <vector>

#include "host/core/base/pose.hpp"
#include "host/core/scene/gaussians.hpp"
#include "host/core/scene/ray_drop.hpp"
#include "host/core/sensors/camera.hpp"
#include "host/core/sensors/lidar.hpp"

namespace simuli::test {

/// A seeded random number generator.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// Returns a number in [low, high).
  [[nodiscard]] double uniform(double low, double high);
  /// Returns a standard normal number (Box-Muller).
  [[nodiscard]] double normal();
  [[nodiscard]] Eigen::Vector3d in_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high);
  /// Returns a direction uniform on the unit sphere.
  [[nodiscard]] Eigen::Vector3d direction();
  /// Returns a rotation uniform over all rotations.
  [[nodiscard]] Eigen::Quaterniond rotation();

 private:
  std::mt19937_64 engine_;
};

/// Parameters of random_set(). Scales are uniform in their logarithm, opacities uniform.
struct SetRecipe {
  SetKind kind = SetKind::kCamera;
  int sh_degree = 0;
  Eigen::Index count = 100;
  Eigen::Vector3d low{-5.0, -5.0, -5.0};  // m, box of the means, from the scene origin
  Eigen::Vector3d high{5.0, 5.0, 5.0};
  double scale_min = 0.02, scale_max = 0.5;  // m
  double opacity_min = 0.05, opacity_max = 0.95;
  double sh_spread = 0.5;  // standard deviation of every SH coefficient
};

/// Returns [recipe.count] particles. Quaternions are deliberately not normalised.
[[nodiscard]] GaussianSet random_set(const SetRecipe& recipe, std::uint64_t seed);

/// One particle of a degree-0 set. `feature` is the rendered feature (without the bias).
struct SingleParticle {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();   // m
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  // m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double opacity = 0.5;
  Eigen::Vector3d feature = Eigen::Vector3d::Constant(0.5);
};
[[nodiscard]] GaussianSet set_of(SetKind kind, const std::vector<SingleParticle>& particles);

/// Returns the set in the order of `order`, a permutation of 0..size-1.
[[nodiscard]] GaussianSet permuted(const GaussianSet& set, const std::vector<Eigen::Index>& order);
/// Returns a seeded permutation of 0..count-1.
[[nodiscard]] std::vector<Eigen::Index> random_order(Eigen::Index count, std::uint64_t seed);

/// Returns a pinhole with a central principal point and a focal length of 0.6 widths (80 degrees across).
[[nodiscard]] Camera small_camera(int width, int height, ShutterKind shutter = ShutterKind::kGlobal);
/// Returns a LiDAR with a full revolution from azimuth_first = pi counter-clockwise, elevations evenly from
/// +10 to -25 degrees, no offsets, 1 to 80 m, ideal rays.
[[nodiscard]] Lidar small_lidar(int rows, int columns);
/// Returns a drop function that depends on all parameters: RayDrop::start() plus normal numbers.
[[nodiscard]] RayDrop::Parameters some_ray_drop(std::uint64_t seed);
/// Returns the camera axes (x right, y down, z forward) of a camera along +x of a z-up frame.
[[nodiscard]] Pose forward_from_camera();

}  // namespace simuli::test
