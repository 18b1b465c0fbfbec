#include "bench/particles/particle_street.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "host/core/base/linear_algebra.hpp"
#include "host/core/base/splitmix.hpp"
#include "host/core/scene/particle_order.hpp"

namespace simuli {
namespace {

/// splitmix64: fast and identical on all machines.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high) {
    const std::uint64_t z = splitmix(state_);
    state_ += kSplitmixStep;
    return low + (high - low) * static_cast<double>(z >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

struct Patch {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
};

Patch draw(Random& random, double length_m) {
  const double x = random.uniform(-0.5 * length_m, 0.5 * length_m);
  const double kind = random.uniform(0.0, 1.0);
  const double side = random.uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
  if (kind < 0.40) return {{x, random.uniform(-10.0, 10.0), 0.0}, Eigen::Vector3d::UnitZ()};
  if (kind < 0.80) return {{x, side * 10.0, random.uniform(0.0, 12.0)}, Eigen::Vector3d(0, -side, 0)};
  if (kind < 0.95) {  // parked cars: the sides of boxes every 7 m
    const double centre = std::round(x / 7.0) * 7.0;
    const double u = random.uniform(-2.2, 2.2);
    const double z = random.uniform(0.1, 1.5);
    if (random.uniform(0.0, 1.0) < 0.7) return {{centre + u, side * 5.2, z}, Eigen::Vector3d(0, -side, 0)};
    return {{centre + (u < 0 ? -2.2 : 2.2), side * random.uniform(5.2, 7.0), z}, Eigen::Vector3d::UnitX()};
  }
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0.0);
  return {Eigen::Vector3d(std::round(x / 12.0) * 12.0, side * 8.0, random.uniform(0.0, 6.0)) + 0.08 * out,
          out};
}

}  // namespace

GaussianSet street_particles(
    SetKind kind, int sh_degree, Eigen::Index count, std::uint64_t seed, StreetOrder order, double length_m) {
  GaussianSet set(kind, sh_degree, count);
  Random random(seed);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Patch patch = draw(random, length_m);
    const Eigen::Quaterniond turn = turn_between(Eigen::Vector3d::UnitZ(), patch.normal);
    set.mean().row(i) = patch.position.cast<float>();
    set.rotation().row(i) << static_cast<float>(turn.w()), static_cast<float>(turn.x()),
        static_cast<float>(turn.y()), static_cast<float>(turn.z());
    const double scale = random.uniform(std::log(0.03), std::log(0.15));
    set.log_scale().row(i) << static_cast<float>(scale),
        static_cast<float>(scale + random.uniform(-0.5, 0.5)), static_cast<float>(scale - 1.5);
    const double opacity = random.uniform(0.1, 0.95);
    set.opacity_logit()(i) = static_cast<float>(std::log(opacity / (1.0 - opacity)));
    for (int k = 0; k < sh_coefficients(sh_degree); ++k) {
      const double spread = k == 0 ? 1.2 : 0.1;
      for (int c = 0; c < 3; ++c) set.sh(k)(i, c) = static_cast<float>(random.uniform(-spread, spread));
    }
  }
  return order == StreetOrder::kShuffled ? set : in_coherent_order(std::move(set));
}

Pose world_from_street_lidar() { return {Eigen::Quaterniond::Identity(), {0.0, -1.7, 1.9}}; }

}  // namespace simuli
