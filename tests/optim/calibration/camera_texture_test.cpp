// Tests the information of texture on a mounting, piece by piece.
#include "optim/calibration/camera/camera_texture.hpp"

#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace simuli::calibration {
namespace {

/// An accelerated motion around a bend.
Trajectory bend() {
  std::vector<TimedPose> poses;
  for (int i = 0; i <= 40; ++i) {
    const double t = 0.05 * i;
    poses.push_back(
        {t,
         {Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * t * t, Eigen::Vector3d(0.1, 0.0, 1.0).normalized())),
          {4.0 * t + t * t, 0.5 * t * t, 0.0}}});
  }
  return Trajectory(poses);
}

Mounting forward_camera() {
  Eigen::Matrix<double, 3, 4> rig_from_camera;
  rig_from_camera << 0, 0, 1, 1.4, -1, 0, 0, 0.1, 0, -1, 0, 1.5;
  return {Pose::from_matrix(rig_from_camera), 0.013};
}

TEST(CameraTexture, DerivativesOfAPointAreThoseOfTheMounting) {
  const Trajectory path = bend();
  const Mounting mounting = forward_camera();
  std::mt19937_64 dice(4);
  std::uniform_real_distribution<double> in(-3.0, 3.0);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p_world(15.0 + in(dice), in(dice), 1.0 + 0.3 * in(dice));
    const CameraPoint point = camera_point(path, mounting, 1.02, p_world);
    for (int k = 0; k < 7; ++k) {
      const double h = 1e-5;
      const auto at = [&](double step) {
        return camera_point(path, moved(mounting, step * MountingStep::Unit(k)), 1.02, p_world).position;
      };
      const Eigen::Vector3d numeric = (at(h) - at(-h)) / (2.0 * h);
      // The clock's derivative is a difference over 0.1 ms, with an error of half the acceleration and
      // rotation.
      EXPECT_LT((point.slope.col(k) - numeric).norm(), k == 6 ? 2e-3 : 1e-6) << k;
    }
  }
}

TEST(CameraTexture, StepsAddUp) {
  const Mounting mounting = forward_camera();
  MountingStep step;
  step << 0.01, -0.02, 0.03, 0.004, -0.01, 0.02, 0.005;
  EXPECT_LT((step_between(mounting, moved(mounting, step)) - step).norm(), 1e-12);
  EXPECT_LT(step_between(mounting, mounting).norm(), 1e-12);
}

/// A wall 10 m ahead with one pattern for both sensors, passed by a camera.
struct PaintedWall {
  Camera camera;
  std::vector<CameraView> views;
  std::vector<SurfacePoint> points;
  Trajectory path{{{-1.0, {Eigen::Quaterniond::Identity(), {0.0, -1.0, 0.0}}},
                   {0.0, {}},
                   {1.0, {Eigen::Quaterniond::Identity(), {0.0, 2.0, 0.0}}}}};
  Mounting truth{forward_camera().rig_from_camera, 0.0};

  explicit PaintedWall(bool intensity_shows_it) {
    camera = {"wall", 200, 120, 150.0, 150.0, 100.0, 60.0};
    const auto paint = [](double y, double z) {
      return 0.5 + 0.15 * std::sin(7.0 * y + 2.0 * std::sin(3.0 * z)) + 0.15 * std::sin(6.0 * z - 2.0 * y);
    };
    for (int v = 0; v < 9; ++v) {
      const double time_s = 0.05 * (v - 4);
      const Pose world_from_camera = path.at(time_s) * truth.rig_from_camera;
      Image picture(camera.width, camera.height, 1);
      for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
          const Eigen::Vector3d ray = world_from_camera.rotation * camera.unproject({x + 0.5, y + 0.5});
          const double range = (10.0 - world_from_camera.translation.x()) / ray.x();
          const Eigen::Vector3d p = world_from_camera.translation + range * ray;
          picture.at(x, y, 0) = static_cast<float>(paint(p.y(), p.z()));
        }
      }
      views.push_back({Luminance(picture), time_s, time_s});
    }
    std::mt19937_64 dice(8);
    std::uniform_real_distribution<double> in(0.0, 1.0);
    for (int i = 0; i < 30000; ++i) {
      SurfacePoint point;
      const double y = 14.0 * in(dice)-7.0;
      const double z = 9.0 * in(dice)-3.0;
      point.p_world = {10.0, y, z};
      point.normal = -Eigen::Vector3d::UnitX();
      point.plane = static_cast<int>(std::floor(y) + 7.0) + 14 * static_cast<int>(std::floor(z) + 3.0);
      point.intensity = static_cast<float>(intensity_shows_it ? 0.2 + 0.6 * paint(y, z) : in(dice));
      point.time_s = 0.5 * i / 30000.0 - 0.25;
      points.push_back(point);
    }
  }
};

MountingMatrix believed() {
  MountingStep sigma;
  sigma << 0.05, 0.05, 0.05, 0.01, 0.01, 0.01, 0.01;
  return sigma.cwiseAbs2().asDiagonal();
}

TEST(CameraTexture, MovesTheCameraToWhereBothSensorsAgree) {
  const PaintedWall wall(true);
  MountingStep step;
  step << 0.01, -0.01, 0.005, 0.002, -0.003, 0.002, 0.0;
  const TextureFit fit = fit_texture(
      wall.views, wall.camera, wall.path, wall.points, 0.02, moved(wall.truth, step), believed(), false);
  ASSERT_GT(fit.pieces, 50U);
  EXPECT_GT(fit.after, 0.95);
  EXPECT_GT(fit.after, fit.before);
  EXPECT_EQ(fit.mounting.time_offset_s, 0.0);  // not requested
  // A wall does not distinguish a shift along it from a rotation: only the projection of its points is
  // determined.
  for (const double y : {-3.0, 0.0, 3.0}) {
    const Eigen::Vector3d p(10.0, y, 1.0);
    const Eigen::Vector3d real = camera_point(wall.path, wall.truth, 0.0, p).position;
    const Eigen::Vector3d found = camera_point(wall.path, fit.mounting, 0.0, p).position;
    EXPECT_LT((real / real.z() - found / found.z()).norm() * wall.camera.fx, 0.1) << y;
  }
}

TEST(CameraTexture, StaysWhereThePicturesShowNothingOfTheIntensity) {
  const PaintedWall wall(false);
  const TextureFit fit =
      fit_texture(wall.views, wall.camera, wall.path, wall.points, 0.02, wall.truth, believed(), true);
  EXPECT_EQ(fit.pieces, 0U);
  EXPECT_EQ(fit.mounting.rig_from_camera.translation, wall.truth.rig_from_camera.translation);
  EXPECT_EQ(fit.covariance, believed());
}

}  // namespace
}  // namespace simuli::calibration
