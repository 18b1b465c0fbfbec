// Tests the reference against closed forms and manual computations.
#include "tests/support/reference.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "tests/support/scenes.hpp"

namespace simuli::reference {
namespace reference_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::SingleParticle;

constexpr double kDouble = 1e-12;  // roundings of double arithmetic on values around 1
constexpr double kSingle = 2e-6;   // parameters are stored in single precision, the logit of 0.9 to 1e-7
const Vector3d kBackground(0.1, 0.2, 0.3);

/// Returns a camera of 5x5 pixels with the principal point at the centre of pixel (2,2), along +z of the
/// scene.
Sensor looking_ahead() { return Sensor::of(test::small_camera(5, 5), Pose(), Pose()); }

/// Returns the ray of the central pixel through the particles.
RayResult middle_ray(const std::vector<SingleParticle>& particles, const Options& options = {}) {
  const Particles set(test::set_of(SetKind::kCamera, particles));
  return render(set, looking_ahead(), options, kBackground)[12];
}

SingleParticle ahead(double z, double opacity, double colour) {
  SingleParticle particle;
  particle.mean = {0.0, 0.0, z};
  particle.opacity = opacity;
  particle.feature.setConstant(colour);
  return particle;
}

TEST(Reference, IsotropicParticleHasTheResponseOfItsDistanceFromTheRay) {
  SingleParticle particle = ahead(5.0, 0.8, 0.75);
  particle.scale.setConstant(0.3);
  const Particles set(test::set_of(SetKind::kCamera, {particle}));
  const Camera camera = test::small_camera(40, 30);
  const Sensor sensor = Sensor::of(camera, Pose(), Pose());
  Options options;
  options.ignore_box = true;
  const std::vector<RayResult> results = render(set, sensor, options, kBackground);
  const double variance = 0.3 * 0.3 + 25.0 / (12.0 * camera.fx * camera.fx);
  int seen = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double tx = (x + 0.5 - 20.0) / camera.fx;
      const double ty = (y + 0.5 - 15.0) / camera.fx;
      const double secant2 = 1.0 + tx * tx + ty * ty;
      const double distance2 = 25.0 * (tx * tx + ty * ty) / secant2;  // from the mean to the ray
      double alpha = 0.8 * std::exp(-0.5 * distance2 / variance);
      if (alpha < 1.0 / 255.0) alpha = 0.0;
      const RayResult& result = results[static_cast<std::size_t>(y * camera.width + x)];
      EXPECT_NEAR(result.transmittance, 1.0 - alpha, kSingle);
      EXPECT_NEAR(result.distance, alpha * 5.0 / std::sqrt(secant2), 5 * kSingle);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(result.feature[c], alpha * 0.75 + (1.0 - alpha) * kBackground[c], kSingle);
      }
      seen += result.contributors;
    }
  }
  EXPECT_GT(seen, 20);
  EXPECT_LT(seen, 600);
}

TEST(Reference, AnisotropicParticleIsThinAcrossItsThinAxis) {
  // Thin along the scene's x after a quarter turn about z: axis 1 of the particle points along -x.
  SingleParticle particle = ahead(5.0, 0.8, 0.75);
  particle.scale = {1.0, 0.1, 1.0};
  particle.rotation = Eigen::AngleAxisd(kPi / 2, Vector3d::UnitZ());
  const Particles set(test::set_of(SetKind::kCamera, {particle}));
  Options options;
  options.ignore_box = true;
  options.filter_variance_px2 = 0.0;
  const std::vector<RayResult> results = render(set, looking_ahead(), options, kBackground);
  const double t = 1.0 / 3.0;  // one pixel off: tangent 1/f with f = 3
  // Across the thin axis the response peaks where the ray passes x = 0, which is its own origin.
  const double s2x = 0.01;
  const double tau = 5.0 / (t * t / s2x + 1.0);  // minimises x^2/0.01 + (z-5)^2, x = t z
  const double q = t * t * tau * tau / s2x + (tau - 5.0) * (tau - 5.0);
  EXPECT_LT(0.8 * std::exp(-0.5 * q), 1.0 / 255.0);
  EXPECT_EQ(results[13].contributors, 0);
  const double tau_y = 5.0 / (t * t + 1.0);
  const double q_y = t * t * tau_y * tau_y + (tau_y - 5.0) * (tau_y - 5.0);
  EXPECT_NEAR(results[17].transmittance, 1.0 - 0.8 * std::exp(-0.5 * q_y), 10 * kSingle);
}

TEST(Reference, TwoParticlesBlendFrontToBackWhateverTheirOrderInTheSet) {
  const RayResult result = middle_ray({ahead(8.0, 0.7, 0.25), ahead(4.0, 0.6, 1.0)});
  EXPECT_EQ(result.contributors, 2);
  EXPECT_NEAR(result.transmittance, 0.4 * 0.3, kSingle);
  EXPECT_NEAR(result.distance, 0.6 * 4.0 + 0.4 * 0.7 * 8.0, 10 * kSingle);
  EXPECT_NEAR(result.median_distance, 4.0, kSingle);
  EXPECT_NEAR(result.feature[1], 0.6 * 1.0 + 0.4 * 0.7 * 0.25 + 0.12 * 0.2, kSingle);
}

TEST(Reference, MedianDistanceIsTheParticleAtWhichHalfIsAbsorbed) {
  EXPECT_NEAR(middle_ray({ahead(4.0, 0.3, 1.0), ahead(8.0, 0.7, 1.0), ahead(9.0, 0.7, 1.0)}).median_distance,
              8.0,
              kSingle);
  EXPECT_EQ(middle_ray({ahead(4.0, 0.3, 1.0), ahead(8.0, 0.2, 1.0)}).median_distance, 0.0);
}

TEST(Reference, AlphaIsClampedAndOpaqueRaysEnd) {
  EXPECT_NEAR(middle_ray({ahead(4.0, 0.99999, 1.0)}).transmittance, 1e-3, kDouble);
  const RayResult result =
      middle_ray({ahead(4.0, 0.99999, 1.0), ahead(5.0, 0.99999, 1.0), ahead(6.0, 0.9, 1.0)});
  EXPECT_EQ(result.contributors, 2);  // 1e-6 is below 1e-4 after the second
  EXPECT_NEAR(result.transmittance, 1e-6, kDouble);
}

TEST(Reference, ParticlesOutsideTheRangeOfTauAreLeftOut) {
  SingleParticle behind = ahead(-0.5, 0.9, 1.0);
  Options options;
  options.ignore_box = true;
  EXPECT_EQ(middle_ray({behind}, options).contributors, 0);

  Lidar lidar = test::small_lidar(1, 4);  // azimuths pi, 3 pi/2, 0, pi/2; range 1 to 80 m
  lidar.rows[0].elevation = 0.0;
  const Sensor sensor = Sensor::of(lidar, nominal_rays(lidar), Pose(), Pose());
  for (const auto& [distance, expected] : {std::pair{0.9, 0}, {1.1, 1}, {79.0, 1}, {81.0, 0}}) {
    SingleParticle particle;
    particle.mean = {distance, 0.0, 0.0};
    particle.scale.setConstant(0.1);
    const Particles set(test::set_of(SetKind::kLidar, {particle}));
    EXPECT_EQ(render(set, sensor, {}, kBackground)[2].contributors, expected) << distance;
  }
}

TEST(Reference, OrderIsByRangeOrPerRay) {
  SingleParticle aside;  // range 4.47 m, but 4 m along the middle ray
  aside.mean = {2.0, 0.0, 4.0};
  aside.scale.setConstant(1.5);
  aside.opacity = 0.9;
  aside.feature.setConstant(1.0);
  const SingleParticle straight = ahead(4.3, 0.5, 0.25);
  Options options;
  options.ignore_box = true;
  options.filter_variance_px2 = 0.0;
  const double alpha = 0.9 * std::exp(-0.5 * 4.0 / 2.25);
  const RayResult by_range = middle_ray({aside, straight}, options);
  EXPECT_NEAR(by_range.feature[0], 0.5 * 0.25 + 0.5 * alpha + 0.5 * (1 - alpha) * 0.1, kSingle);
  options.per_ray_order = true;
  const RayResult per_ray = middle_ray({aside, straight}, options);
  EXPECT_NEAR(per_ray.feature[0], alpha + (1 - alpha) * (0.5 * 0.25) + 0.5 * (1 - alpha) * 0.1, kSingle);
  EXPECT_NEAR(per_ray.transmittance, by_range.transmittance, kDouble);
}

TEST(Reference, MarginIsTheDistanceToTheNearestDecision) {
  Options options;
  options.ignore_box = true;
  const RayResult result = middle_ray({ahead(4.0, 0.6, 1.0), ahead(5.0, 0.01, 1.0)}, options);
  EXPECT_EQ(result.contributors, 2);
  EXPECT_NEAR(result.margin, 0.2, kSingle);  // keys 4 and 5 m
  const RayResult close = middle_ray({ahead(4.0, 0.6, 1.0), ahead(5.0, 1.001 / 255.0, 1.0)}, options);
  EXPECT_NEAR(close.margin, 0.001, 10 * kSingle);
}

TEST(ShBasis, IsOrthonormal) {
  // Gauss-Legendre in z (exact to degree 7) times 8 azimuths (exact to frequency 7): products of two
  // functions of degree 3 need 6.
  const double nodes[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
  const double weights[4] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(16, 16);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 8; ++j) {
      const double azimuth = 2.0 * kPi * j / 8.0 + 0.1;
      const double radius = std::sqrt(1.0 - nodes[i] * nodes[i]);
      const Vector3d direction(radius * std::cos(azimuth), radius * std::sin(azimuth), nodes[i]);
      const Eigen::VectorXd basis = sh_basis(3, direction);
      gram += weights[i] * 2.0 * kPi / 8.0 * basis * basis.transpose();
    }
  }
  EXPECT_NEAR((gram - Eigen::MatrixXd::Identity(16, 16)).cwiseAbs().maxCoeff(), 0.0, kDouble);
}

TEST(ShBasis, HasTheSignsOf3dgs) {
  const Eigen::VectorXd x = sh_basis(3, Vector3d::UnitX());
  const Eigen::VectorXd y = sh_basis(3, Vector3d::UnitY());
  const Eigen::VectorXd z = sh_basis(3, Vector3d::UnitZ());
  EXPECT_LT(x[3], 0.0);
  EXPECT_LT(y[1], 0.0);
  EXPECT_GT(z[2], 0.0);
  EXPECT_GT(z[6], 0.0);
  EXPECT_GT(x[8], 0.0);
  EXPECT_GT(z[12], 0.0);
  EXPECT_GT(x[13], 0.0);
  EXPECT_GT(y[11], 0.0);
  EXPECT_LT(x[15], 0.0);
  EXPECT_GT(y[9], 0.0);
  const Eigen::VectorXd diagonal = sh_basis(3, Vector3d(1, 1, 1).normalized());
  EXPECT_GT(diagonal[4], 0.0);
  EXPECT_LT(diagonal[5], 0.0);
  EXPECT_LT(diagonal[7], 0.0);
  EXPECT_GT(diagonal[10], 0.0);
  EXPECT_GT(sh_basis(3, Vector3d(1, 0, 1).normalized())[14], 0.0);
  EXPECT_EQ(sh_basis(1, Vector3d::UnitX()).size(), 4);
}

TEST(Features, AreBiasedForColoursAndBareForLogits) {
  GaussianSet camera(SetKind::kCamera, 1, 1);
  camera.rotation()(0, 0) = 1.0F;
  camera.mean().row(0) << 0.0F, 0.0F, 6.0F;
  camera.sh(0).row(0) << 1.0F, -4.0F, 0.5F;
  camera.sh(2).row(0) << 0.5F, 0.0F, -0.25F;
  GaussianSet lidar = camera;
  lidar.kind = SetKind::kLidar;
  lidar.sh(0)(0, 0) = -4.0F;
  Pose scene_from_camera;
  scene_from_camera.translation = {0.0, 0.0, 1.0};  // the particle is in direction +z
  const double c0 = 0.28209479177387814;
  const double c1 = 0.4886025119029199;
  const Footprint seen = project(
      Particles(camera), Sensor::of(test::small_camera(5, 5), scene_from_camera, scene_from_camera))[0];
  EXPECT_NEAR(seen.feature[0], 0.5 + c0 + 0.5 * c1, kDouble);
  EXPECT_EQ(seen.feature[1], 0.0);
  EXPECT_NEAR(seen.feature[2], 0.5 + 0.5 * c0 - 0.25 * c1, kDouble);
  EXPECT_NEAR(seen.opacity, 0.5, kDouble);
  EXPECT_NEAR(seen.range, 5.0, kDouble);

  const Lidar model = test::small_lidar(2, 8);
  const Footprint scanned = project(
      Particles(lidar), Sensor::of(model, nominal_rays(model), scene_from_camera, scene_from_camera))[0];
  EXPECT_EQ(scanned.feature[0], 0.0);
  EXPECT_NEAR(scanned.feature[1], -4.0 * c0, kDouble);
  EXPECT_NEAR(scanned.feature[2], 0.5 * c0 - 0.25 * c1, kDouble);
}

TEST(Unscented, IsExactForLinearMaps) {
  test::Random random(11);
  Eigen::Matrix<double, 2, 3> map;
  for (int i = 0; i < 6; ++i) map(i / 3, i % 3) = random.normal();
  const Vector3d mean = random.in_box({-3, -3, -3}, {3, 3, 3});
  const Eigen::Matrix3d rotation = random.rotation().toRotationMatrix();
  const Vector3d scale(0.2, 0.5, 1.5);
  const SigmaResult result = unscented(mean, rotation, scale, false, [&](const Vector3d& p, Vector2d& xy) {
    xy = map * p + Vector2d(4.0, -2.0);
    return true;
  });
  const Eigen::Matrix3d covariance =
      rotation * scale.array().square().matrix().asDiagonal() * rotation.transpose();
  ASSERT_TRUE(result.all_valid);
  EXPECT_NEAR((result.mean - (map * mean + Vector2d(4.0, -2.0))).norm(), 0.0, kDouble);
  EXPECT_NEAR((result.covariance - map * covariance * map.transpose()).norm(), 0.0, 10 * kDouble);
}

TEST(Unscented, OfASquareMatchesHandComputation) {
  // x -> x^2 about 0 with scale s: offsets 3 s^2 twice and 0 four times, so the mean is s^2 (exact) and
  // the variance 2 s^4 + (2 (2 s^2)^2 + 4 s^4) / 6 = 4 s^4.
  const double s = 0.7;
  const SigmaResult result = unscented(Vector3d::Zero(),
                                       Eigen::Matrix3d::Identity(),
                                       {s, 1.0, 1.0},
                                       false,
                                       [](const Vector3d& p, Vector2d& xy) {
                                         xy = {p.x() * p.x(), 0.0};
                                         return true;
                                       });
  EXPECT_NEAR(result.mean.x(), s * s, kDouble);
  EXPECT_NEAR(result.covariance(0, 0), 4.0 * std::pow(s, 4), kDouble);
}

TEST(Unscented, OffsetsWrapAtTheEndOfTheCircle) {
  const auto angle = [](const Vector3d& p, Vector2d& xy) {
    xy = {wrapped(p.x()), p.y()};
    return true;
  };
  const SigmaResult result =
      unscented({kPi - 0.01, 0.0, 0.0}, Eigen::Matrix3d::Identity(), {0.1, 0.1, 0.1}, true, angle);
  EXPECT_NEAR(result.mean.x(), kPi - 0.01, kDouble);
  EXPECT_NEAR(result.covariance(0, 0), 0.01, kDouble);
}

TEST(Unscented, TellsInvalidPoints) {
  const auto front_only = [](const Vector3d& p, Vector2d& xy) {
    xy = p.head<2>();
    return p.z() > 0.0;
  };
  const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  const SigmaResult some = unscented({0, 0, 1}, axes, {1, 1, 1}, false, front_only);
  EXPECT_FALSE(some.all_valid);
  EXPECT_TRUE(some.any_valid);
  EXPECT_FALSE(unscented({0, 0, -9}, axes, {1, 1, 1}, false, front_only).any_valid);
}

TEST(Wrapped, IsHalfOpen) {
  EXPECT_EQ(wrapped(kPi), -kPi);
  EXPECT_EQ(wrapped(-kPi), -kPi);
  EXPECT_NEAR(wrapped(7.0), 7.0 - 2.0 * kPi, kDouble);
  EXPECT_NEAR(wrapped(-4.0), 2.0 * kPi - 4.0, kDouble);
  EXPECT_EQ(wrapped(0.5), 0.5);
}

}  // namespace reference_test
}  // namespace simuli::reference
