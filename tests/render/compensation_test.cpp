// Tests opacity compensation of the footprint filter: the remaining share of a particle's opacity.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/cl/support.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

/// Returns the square root of the ratio of a particle's areas across `direction`, before and after `variance`
/// is added: of the covariance in two perpendicular axes.
double kept_share(const test::SingleParticle& p, const Eigen::Vector3d& direction, double variance) {
  const Eigen::Matrix3d r = p.rotation.toRotationMatrix();
  const Eigen::Matrix3d covariance = r * p.scale.cwiseAbs2().asDiagonal() * r.transpose();
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = direction.unitOrthogonal();
  across.col(1) = direction.cross(across.col(0)).normalized();
  const Eigen::Matrix2d narrow = across.transpose() * covariance * across;
  const Eigen::Matrix2d wide = narrow + variance * Eigen::Matrix2d::Identity();
  return std::sqrt(narrow.determinant() / wide.determinant());
}

class OpacityCompensation : public testing::TestWithParam<Precision> {};

TEST_P(OpacityCompensation, ScalesAlphaByTheAreaBeforeAndAfter) {
  const Device& device = test::device();
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  // The set's parameters are floats, the reference's are double.
  const double tolerance = GetParam() == Precision::kDouble ? 1e-7 : 1e-5;
  for (const test::SceneCase& scene : {test::kCameraRolling, test::kLidarMoving}) {
    const bool camera = scene.kind == SetKind::kCamera;
    test::Shot shot = test::shot_of(scene, camera ? 64 : 240, camera ? 48 : 16);
    // equal poses, so that directions are known
    shot.view.scene_from_sensor_end = shot.view.scene_from_sensor_start;
    shot.lidar.beam_divergence = 0.04;
    shot.lidar.divergence_variance = 1.0;
    const Eigen::Vector3d place(6.0, 0.8, -0.4);
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, -2, 0.5).normalized()));
    const test::SingleParticle particle{
        .mean = place, .scale = {0.02, 0.1, 0.4}, .rotation = turned, .opacity = 0.8};
    GaussianSet set(scene.kind, scene.sh_degree, 1);
    set.params.leftCols(kShRow + 3) = test::set_of(scene.kind, {particle}).params;
    RenderOptions options = paper_options();
    options.precision = GetParam();
    options.alpha_cut = 1e-6;
    options.camera_filter_px2 = 0.3;  // large enough for a measurable effect
    const auto alpha = [&](bool compensated) {
      RenderOptions chosen = options;
      chosen.camera_compensation = chosen.lidar_compensation = compensated;
      Renderer renderer(device, chosen);
      const SensorRays rays = shot.on(device, chosen);
      std::vector<double> out =
          test::outputs(renderer.render(ParticleBuffers(device, set, GetParam()), rays, shot.view));
      const std::size_t s = rays.grid().frame.slots;
      std::vector<double> a;
      for (std::size_t i = 0; i < s; ++i) a.push_back(1.0 - out[3 * s + i]);
      return a;
    };
    const std::vector<double> plain = alpha(false), kept = alpha(true);
    const Eigen::Vector3d centre = shot.view.scene_from_sensor_start.translation;
    const double range = (place - centre).norm();
    const double kappa = camera ? options.camera_filter_px2 / std::pow(shot.camera.focal_px(), 2)
                                : std::pow(std::tan(0.02), 2);
    const double share = kept_share(particle, (place - centre) / range, kappa * range * range);
    EXPECT_LT(share, 0.8);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      if (plain[i] < 0.05) continue;
      ++compared;
      EXPECT_NEAR(kept[i] / plain[i], share, tolerance / plain[i]);
    }
    EXPECT_GT(compared, 3U);
  }
}

TEST_P(OpacityCompensation, WithoutAFootprintNothingChanges) {
  const Device& device = test::device();
  if (GetParam() == Precision::kDouble) SIMULI_NEEDS_DOUBLE(device);
  const test::Shot shot = test::shot_of(test::kCameraRolling, 40, 30);
  const GaussianSet set = test::set_for(test::kCameraRolling, {.count = 60}, 6);
  std::vector<double> out[2];
  for (const bool compensated : {false, true}) {
    RenderOptions options = paper_options();
    options.precision = GetParam();
    options.camera_filter_px2 = 0.0;
    options.camera_compensation = compensated;
    Renderer renderer(device, options);
    const SensorRays rays = shot.on(device, options);
    Pass pass = renderer.render(ParticleBuffers(device, set, GetParam()), rays, shot.view);
    out[compensated ? 1 : 0] = test::outputs(pass);
  }
  for (std::size_t i = 0; i < out[0].size(); ++i) {
    ASSERT_NEAR(out[1][i], out[0][i], (GetParam() == Precision::kDouble ? 1e-12 : 1e-5) * (1.0 + out[0][i]));
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         OpacityCompensation,
                         testing::Values(Precision::kFloat, Precision::kDouble),
                         [](const auto& pair) {
                           return pair.param == Precision::kFloat ? "in_float" : "in_double";
                         });

}  // namespace
}  // namespace simuli
