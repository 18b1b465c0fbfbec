#include "tests/support/scenes.hpp"

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "host/core/base/error.hpp"

namespace simuli::test {
namespace {

double logit(double probability) { return std::log(probability / (1.0 - probability)); }

void set_rotation(GaussianSet& set, Eigen::Index particle, const Eigen::Quaterniond& q, double length) {
  set.rotation().row(particle) = (length * Eigen::RowVector4d(q.w(), q.x(), q.y(), q.z())).cast<float>();
}

}  // namespace

double Random::uniform(double low, double high) {
  // The top 53 bits: every double of the grid in [0,1) is equally likely.
  const double unit = static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  return low + (high - low) * unit;
}

double Random::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0)));
  return radius * std::cos(uniform(0.0, 2.0 * std::numbers::pi));
}

Eigen::Vector3d Random::in_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  Eigen::Vector3d point;
  for (int axis = 0; axis < 3; ++axis) point[axis] = uniform(low[axis], high[axis]);
  return point;
}

Eigen::Vector3d Random::direction() {
  Eigen::Vector3d v;
  for (int axis = 0; axis < 3; ++axis) v[axis] = normal();
  return v.normalized();
}

Eigen::Quaterniond Random::rotation() {
  Eigen::Vector4d q;
  for (int axis = 0; axis < 4; ++axis) q[axis] = normal();
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
}

GaussianSet random_set(const SetRecipe& recipe, std::uint64_t seed) {
  Random random(seed);
  GaussianSet set(recipe.kind, recipe.sh_degree, recipe.count);
  const double log_low = std::log(recipe.scale_min);
  const double log_high = std::log(recipe.scale_max);
  for (Eigen::Index i = 0; i < recipe.count; ++i) {
    set.mean().row(i) = random.in_box(recipe.low, recipe.high).transpose().cast<float>();
    for (int axis = 0; axis < 3; ++axis) {
      set.log_scale()(i, axis) = static_cast<float>(random.uniform(log_low, log_high));
    }
    const Eigen::Quaterniond q = random.rotation();
    set_rotation(set, i, q, random.uniform(0.5, 2.0));
    set.opacity_logit()(i) =
        static_cast<float>(logit(random.uniform(recipe.opacity_min, recipe.opacity_max)));
    for (int column = kShRow; column < param_rows(recipe.sh_degree); ++column) {
      set.params(i, column) = static_cast<float>(recipe.sh_spread * random.normal());
    }
  }
  return set;
}

GaussianSet set_of(SetKind kind, const std::vector<SingleParticle>& particles) {
  GaussianSet set(kind, 0, static_cast<Eigen::Index>(particles.size()));
  for (std::size_t k = 0; k < particles.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const SingleParticle& particle = particles[k];
    set.mean().row(i) = particle.mean.transpose().cast<float>();
    set.log_scale().row(i) = particle.scale.array().log().matrix().transpose().cast<float>();
    set_rotation(set, i, particle.rotation, 1.0);
    set.opacity_logit()(i) = static_cast<float>(logit(particle.opacity));
    // The logits of a LiDAR set have no bias.
    const Eigen::Vector3d bias =
        kind == SetKind::kCamera ? Eigen::Vector3d::Constant(0.5) : Eigen::Vector3d(0.5, 0.0, 0.0);
    set.sh(0).row(i) = ((particle.feature - bias) / static_cast<double>(kSh0)).transpose().cast<float>();
  }
  return set;
}

GaussianSet permuted(const GaussianSet& set, const std::vector<Eigen::Index>& order) {
  if (static_cast<Eigen::Index>(order.size()) != set.size()) {
    throw Error(ErrorKind::kInternal, "permutation of another length than the set");
  }
  GaussianSet out(set.kind, set.sh_degree, set.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    out.params.row(static_cast<Eigen::Index>(i)) = set.params.row(order[i]);
  }
  return out;
}

std::vector<Eigen::Index> random_order(Eigen::Index count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(i)))]);
  }
  return order;
}

Camera small_camera(int width, int height, ShutterKind shutter) {
  Camera camera;
  camera.name = "small";
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.6 * width;
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  camera.shutter = shutter;
  return camera;
}

Lidar small_lidar(int rows, int columns) {
  constexpr double kTop_rad = 10.0 * std::numbers::pi / 180.0;
  constexpr double kBottom_rad = -25.0 * std::numbers::pi / 180.0;
  Lidar lidar;
  lidar.name = "small";
  for (int r = 0; r < rows; ++r) {
    const double share = rows > 1 ? static_cast<double>(r) / (rows - 1) : 0.5;
    lidar.rows.push_back({.elevation = kTop_rad + share * (kBottom_rad - kTop_rad)});
  }
  lidar.columns = columns;
  lidar.azimuth_first = std::numbers::pi;
  lidar.azimuth_span = 2.0 * std::numbers::pi;
  lidar.range_min = 1.0;
  lidar.range_max = 80.0;
  return lidar;
}

RayDrop::Parameters some_ray_drop(std::uint64_t seed) {
  Random random(seed);
  RayDrop::Parameters parameters = RayDrop::start();
  for (double& parameter : parameters) parameter += 0.7 * random.normal();
  return parameters;
}

Pose forward_from_camera() {
  Eigen::Matrix<double, 3, 4> m;
  m << 0, 0, 1, 0,  //
      -1, 0, 0, 0,  //
      0, -1, 0, 0;
  return Pose::from_matrix(m);
}

}  // namespace simuli::test
