// Tests lenses on the device: projection in float and double against the host, and rendered pictures against
// the reference.
#include <cmath>
#include <gtest/gtest.h>
#include <iostream>

#include "host/core/base/angles.hpp"
#include "host/device/runtime/kernel.hpp"
#include "tests/cl/support.hpp"
#include "tests/host/opencv_cameras.hpp"
#include "tests/host/windshields.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Maximum error of a float pipeline: a hundredth of a pixel.
constexpr double kFloat_px = 0.01;
// A float may decide differently about points this close to the end of the domain.
constexpr double kDecided_rad = 3e-4;

constexpr const char* kProbe = R"(
#include "math/sensor.h"
__kernel void probe(__global const SensorConstants* sensor, __global const real* points, __global real* out, const uint n) {
  const uint i = get_global_id(0) * V;
  const F p[3] = {LDV(points + i), LDV(points + n + i), LDV(points + 2 * n + i)};
  F x, y;
  I valid = (F)R(0.0) == (F)R(0.0);
  project_point(sensor, p, &x, &y, &valid);
  STV(out + i, x);
  STV(out + n + i, y);
  STV(out + 2 * n + i, SEL(valid, (F)R(1.0), (F)R(0.0)));
}
)";

struct Images {
  std::vector<double> x, y;
  std::vector<bool> valid;
};

Images project_on_device(const Camera& camera,
                         const std::vector<Vector3d>& points,
                         Precision precision,
                         int lanes) {
  const Device& device = test::device();
  BuildOptions options;
  options.real(precision).define("V", lanes).define("SENSOR", 0).define("MOVING", 0);
  options.define("LENS", camera.lens.kind());
  options.define("WINDSHIELD", static_cast<int>(camera.lens.constants().bend));
  shared::SensorConstants<double> sensor{};
  sensor.model.fx = camera.fx;
  sensor.model.fy = camera.fy;
  sensor.model.cx = camera.cx;
  sensor.model.cy = camera.cy;
  sensor.model.period = camera.width;
  sensor.model.lens = camera.lens.constants();
  const std::size_t n = round_up(points.size(), static_cast<std::size_t>(lanes));
  std::vector<double> columns(3 * n, 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) columns[k * n + i] = points[i][static_cast<Eigen::Index>(k)];
  }
  StructBuffer<shared::SensorConstants> sensor_buffer(device, "sensor", precision);
  RealBuffer in(device, "points", precision), out(device, "out", precision, 3 * n);
  sensor_buffer.assign(shared::reals_of(sensor));
  in.assign(std::span<const double>(columns));
  out.fill(-7.0);
  Kernel(Program::from_text(device, "probe.cl", kProbe, options), "probe")
      .run(n / static_cast<std::size_t>(lanes),
           1,
           {{"sensor", sensor_buffer}, {"points", in}, {"out", out}, {"n", static_cast<std::uint32_t>(n)}});
  const std::vector<double> result = out.download_double();
  Images images;
  for (std::size_t i = 0; i < points.size(); ++i) {
    images.x.push_back(result[i]);
    images.y.push_back(result[n + i]);
    images.valid.push_back(result[2 * n + i] > 0.5);
  }
  return images;
}

Camera camera_of(LensKind kind, const std::vector<double>& parameters) {
  Camera camera;
  camera.name = to_string(kind);
  camera.width = 1920;
  camera.height = 1200;
  camera.fx = kind == LensKind::kEquirectangular ? 1920 / (2 * kPi) : 900.0;
  camera.fy = kind == LensKind::kEquirectangular ? camera.fx : 910.0;
  camera.cx = 955.0;
  camera.cy = 590.0;
  if (kind != LensKind::kPinhole) camera.lens = Lens(kind, parameters);
  return camera;
}

Camera behind(const Windshield& glass, Camera camera) {
  camera.name += glass.reference == Windshield::Reference::kForward ? ", glass" : ", glass by its way back";
  camera.lens = camera.lens.behind(glass);
  return camera;
}

std::vector<Camera> one_camera_of_each_lens() {
  return {
      behind(test::glass_before_the_lens(), camera_of(LensKind::kPinhole, {})),
      behind(test::glass_by_its_way_back(),
             camera_of(LensKind::kOpencvFisheye, {-0.03, -0.005, -0.0008, 0.001, 1.9})),
      camera_of(LensKind::kPinhole, {}),
      camera_of(LensKind::kOpencvPinhole, {-0.5894, 0.66, 0.0011, -0.001, -1.0088, 0, 0, 0, 0, 0, 0, 0, kPi}),
      camera_of(LensKind::kOpencvFisheye, {-0.03, -0.005, -0.0008, 0.001, 1.9}),
      camera_of(LensKind::kFtheta, {1.0, -0.02, 0.06, -0.095, 0.034, 0.9997, 0.0034, -0.002, 1.35}),
      camera_of(LensKind::kFthetaInverse, {1.0, 0.03, -0.08, 0.11, -0.03, 1.0002, -0.001, 0.0005, 1.3}),
      camera_of(LensKind::kMei, {0.017, 1.65, 0.0004, 0.0004, 2.2, kPi}),
      camera_of(LensKind::kEquirectangular, {}),
      camera_of(LensKind::kDoubleSphere, {-0.17, 0.593, kPi}),
      camera_of(LensKind::kEucm, {0.63, 1.04, kPi})};
}

/// Whether the host decides equally for all points within kDecided_rad.
bool decided(const Camera& camera, const Vector3d& p) {
  Vector2d pixel;
  const bool valid = camera.project(p, pixel);
  const Vector3d across = p.unitOrthogonal() * p.norm();
  const Vector3d other = p.normalized().cross(across);
  for (const double step : {-kDecided_rad, kDecided_rad}) {
    if (camera.project(p + step * across, pixel) != valid) return false;
    if (camera.project(p + step * other, pixel) != valid) return false;
    const Vector3d along_axis =
        p + step * p.norm() * (Vector3d::UnitZ() - p * p.z() / p.squaredNorm()).normalized();
    if (along_axis.allFinite() && camera.project(along_axis, pixel) != valid) return false;
  }
  return true;
}

TEST(CameraModel, TheDeviceProjectsAsTheHostDoes) {
  test::Random random(11);
  std::vector<Vector3d> points;
  for (int i = 0; i < 4096; ++i) points.push_back(std::exp(random.uniform(-2.0, 6.0)) * random.direction());
  for (const Vector3d& edge :
       {Vector3d(0, 0, 1), Vector3d(0, 0, -1), Vector3d(0, 0, 0.005), Vector3d(1e-25, 0, 2)}) {
    points.push_back(edge);
  }
  // Around the fold of the OpenCV pinhole, whose radius depends on the direction.
  for (int i = 0; i < 4096; ++i) {
    const double radius = std::tan(random.uniform(0.58, 0.66)), direction = random.uniform(0.0, 2.0 * kPi);
    points.emplace_back(radius * std::cos(direction), radius * std::sin(direction), 1.0);
  }
  const bool fp64 = test::has_double(test::device());
  struct Build {
    Precision precision;
    int lanes;
    double tolerance_px;
  };
  for (const Camera& camera : one_camera_of_each_lens()) {
    for (const Build& build : {Build{Precision::kFloat, 16, kFloat_px},
                               Build{Precision::kFloat, 1, kFloat_px},
                               Build{Precision::kDouble, 8, 1e-8}}) {
      // Each build takes most of a second: variants of the lanes only for the two longest lenses.
      const bool both =
          camera.lens.kind() == LensKind::kOpencvPinhole || camera.lens.kind() == LensKind::kFthetaInverse;
      if (build.lanes != 16 && !both) continue;
      if (build.precision == Precision::kDouble && !fp64) continue;
      const Images images = project_on_device(camera, points, build.precision, build.lanes);
      std::size_t compared = 0, rejected = 0;
      double worst = 0.0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        Vector2d expected;
        const bool valid = camera.project(points[i], expected);
        if (!decided(camera, points[i])) continue;
        ASSERT_EQ(images.valid[i], valid) << camera.name << " " << points[i].transpose();
        if (!valid) {
          ++rejected;
          continue;
        }
        ++compared;
        Vector2d miss = Vector2d(images.x[i], images.y[i]) - expected;
        if (camera.lens.kind() == LensKind::kEquirectangular)
          miss.x() = std::remainder(miss.x(), camera.width);
        // Far outside the picture a float cannot resolve hundredths of a pixel.
        double allowed = std::max(build.tolerance_px, build.tolerance_px * 1e-4 * expected.norm());
        // asin() loses accuracy for rays that graze the glass.
        if (camera.lens.windshield())
          allowed = std::max(allowed, build.tolerance_px * 1e-6 * expected.squaredNorm());
        EXPECT_LT(miss.norm(), allowed)
            << camera.name << " " << points[i].transpose() << " lanes " << build.lanes;
        if (expected.norm() < 2500.0) worst = std::max(worst, miss.norm());
      }
      EXPECT_GT(compared, 200U) << camera.name;
      EXPECT_GT(rejected, camera.lens.kind() == LensKind::kEquirectangular ? 0U : 50U) << camera.name;
      std::cout << camera.name << (build.precision == Precision::kFloat ? " float" : " double") << " x"
                << build.lanes << ": worst " << worst << " px of " << compared << ", " << rejected
                << " rejected\n";
    }
  }
}

TEST(CameraModel, TheFloatPathMatchesOpenCv) {
  const auto cases = test::opencv_cameras();
  if (cases.empty()) GTEST_SKIP() << "not run: projections by OpenCV of 39 cameras, SIMULI_DATA is not set";
  double worst = 0.0;
  for (const test::OpencvCamera& c : cases) {
    const Images images = project_on_device(c.camera, c.points, Precision::kFloat, 16);
    for (std::size_t i = 0; i < c.points.size(); ++i) {
      const bool past = c.off_axis_deg(i) > c.fold_deg + test::kFoldRounding_deg;
      EXPECT_FALSE(past && images.valid[i]) << c.camera.name << " point " << i;
      if (c.off_axis_deg(i) > c.fold_deg - test::kFoldRounding_deg) continue;
      ASSERT_TRUE(images.valid[i]) << c.camera.name << " point " << i;
      const double miss = (Vector2d(images.x[i], images.y[i]) - c.pixels[i]).norm();
      EXPECT_LT(miss, std::max(kFloat_px, 1e-6 * c.pixels[i].norm())) << c.camera.name << " point " << i;
      worst = std::max(worst, miss);
    }
  }
  std::cout << "worst " << worst << " px\n";
}

/// A camera with its scene: particles all around the camera, none nearer than 2 m.
struct Picture {
  GaussianSet set;
  test::Shot shot;
};

Picture picture_of(const Camera& camera, bool moving) {
  Picture picture;
  const test::SceneCase scene_case = moving ? test::kCameraRolling : test::kCameraStill;
  picture.shot = test::shot_of(scene_case, camera.width, camera.height);
  picture.shot.camera = camera;
  test::SetRecipe recipe{.count = 500, .low = {-6, -6, -6}, .high = {6, 6, 6}};
  recipe.scale_min = 0.05;
  recipe.scale_max = 0.25;
  picture.set = test::set_for(scene_case, recipe, 5);
  for (Eigen::Index i = 0; i < picture.set.size(); ++i) {
    auto mean = picture.set.mean().row(i);
    const float range = mean.norm();
    if (range < 2.5F) mean *= 2.5F / range;
  }
  return picture;
}

/// Compares a picture with the reference without boxes, which uses neither tiles nor sigma points.
void expect_reference(const Picture& picture, std::size_t least_covered) {
  const Device& device = test::device();
  RenderOptions options = paper_options();
  options.camera_filter_px2 =
      kSplatVariance_px2;  // so that particles smaller than a coarse pixel are visible
  Renderer renderer(device, options);
  const ParticleBuffers particles(device, picture.set, Precision::kFloat);
  const SensorRays rays = picture.shot.on(device, renderer.options());
  const RayResults results = renderer.render(particles, rays, picture.shot.view).results();
  const auto& background = picture.shot.view.background;
  const auto expected = reference::render(reference::Particles(picture.set),
                                          picture.shot.reference(),
                                          {.filter_variance_px2 = kSplatVariance_px2, .ignore_box = true},
                                          {static_cast<double>(background[0]),
                                           static_cast<double>(background[1]),
                                           static_cast<double>(background[2])});
  ASSERT_EQ(results.rays, expected.size());
  // A box of seven sigma points ends where alpha is about 1/255: a few rays lose a few times that.
  constexpr double kBoxed = 0.03, kBoxedMean = 5e-4;
  double worst = 0.0, sum = 0.0;
  std::size_t covered = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double miss = std::abs(static_cast<double>(results.transmittance[i]) - expected[i].transmittance);
    EXPECT_LT(miss, kBoxed) << "ray " << i;
    worst = std::max(worst, miss);
    sum += miss;
    covered += expected[i].contributors > 0;
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(static_cast<double>(results.feature[c][i]),
                  expected[i].feature[static_cast<Eigen::Index>(c)],
                  3 * kBoxed)
          << "ray " << i;
    }
  }
  const double mean = sum / static_cast<double>(expected.size());
  EXPECT_LT(mean, kBoxedMean);
  EXPECT_GT(covered, least_covered);
  std::cout << covered << " rays covered, worst " << worst << ", mean " << mean << "\n";
}

TEST(CameraModel, AFisheyeBeyondAHalfTurnWithARollingShutterMatchesTheReference) {
  Camera camera;
  camera.name = "fisheye";
  camera.width = 88;
  camera.height = 72;
  camera.fx = 22.0;
  camera.fy = 21.5;
  camera.cx = 43.0;
  camera.cy = 36.5;
  camera.shutter = ShutterKind::kTopToBottom;
  camera.lens = Lens(LensKind::kOpencvFisheye, {0.004, 0.002, 0.0, 0.0005, 1.95});
  ASSERT_GT(pixels_without_ray(camera), 100U);
  const Picture picture = picture_of(camera, true);
  ASSERT_GT(reference::camera_direction(camera, {0.5, 36.5}).norm(), 0.0);
  // the pixel shows a direction to the rear
  ASSERT_LT(reference::camera_direction(camera, {0.5, 36.5}).z(), -0.2);
  expect_reference(picture, 3000);
}

Camera panorama() {
  Camera camera;
  camera.name = "panorama";
  camera.width = 100;  // the last tile column is partial
  camera.height = 50;
  camera.fx = camera.fy = 100 / (2 * kPi);
  camera.cx = 31.0;  // the seam is not straight behind
  camera.cy = 25.0;
  camera.lens = Lens(LensKind::kEquirectangular, {});
  return camera;
}

TEST(CameraModel, AnEquirectangularPictureWrapsAndMatchesTheReference) {
  expect_reference(picture_of(panorama(), false), 4000);
}

TEST(CameraModel, AParticleAtThePanoramasSeamIsInFewTiles) {
  Picture picture = picture_of(panorama(), false);
  // The seam is at the azimuth (0 - cx) / fx to the right of the optical axis, the world's x axis.
  const double azimuth = -31.0 / panorama().fx;
  test::SingleParticle particle;
  particle.mean = 5.0 * Vector3d(std::cos(azimuth), -std::sin(azimuth), 0.0);
  particle.scale.setConstant(0.05);
  picture.set = test::set_of(SetKind::kCamera, {particle});
  const Device& device = test::device();
  Renderer renderer(device, paper_options());
  const ParticleBuffers particles(device, picture.set, Precision::kFloat);
  const SensorRays rays = picture.shot.on(device, renderer.options());
  Pass pass = renderer.render(particles, rays, picture.shot.view);
  // One tile row, two of its seven tiles.
  EXPECT_EQ(pass.buffers().binned.pairs, 2U);
  const RayResults results = pass.results();
  EXPECT_LT(results.transmittance[25 * 100], 0.99F);
  EXPECT_LT(results.transmittance[25 * 100 + 99], 0.99F);
}

TEST(CameraModel, PixelsWithoutARayAreBackgroundAndNoTrainingSignal) {
  constexpr int kWidth = 100, kHeight = 70;
  Camera camera = panorama();
  camera.height = kHeight;  // taller than from pole to pole
  camera.cy = 35.0;
  Picture picture = picture_of(camera, false);
  std::vector<test::SingleParticle> around;  // balls on all six sides
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (const double side : {-3.0, 3.0}) {
      around.emplace_back();
      around.back().mean[axis] = side;
      around.back().scale.setConstant(3.0);
      around.back().opacity = 0.9;
    }
  }
  picture.set = test::set_of(SetKind::kCamera, around);
  const Device& device = test::device();
  Renderer renderer(device, paper_options());
  const ParticleBuffers particles(device, picture.set, Precision::kFloat);
  const SensorRays rays = picture.shot.on(device, renderer.options());
  Pass pass = renderer.render(particles, rays, picture.shot.view);
  const RayResults results = pass.results();
  std::size_t without = 0;
  for (std::size_t i = 0; i < results.rays; ++i) {
    const double row = static_cast<double>(i / kWidth) + 0.5;
    const bool outside = std::abs(row - camera.cy) / camera.fy > kPi / 2;
    without += outside;
    if (outside) {
      EXPECT_EQ(results.transmittance[i], 1.0F);
      EXPECT_EQ(results.distance[i], 0.0F);
      for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(results.feature[c][i], picture.shot.view.background[c]);
    } else {
      EXPECT_LT(results.transmittance[i], 0.5F) << "ray " << i;
    }
  }
  EXPECT_EQ(without, rays.grid().without_ray);
  EXPECT_EQ(without, 20U * kWidth);
  // A picture that differs only in these pixels has no loss.
  std::vector<float> truth(3 * results.rays);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < results.rays; ++i) {
      truth[c * results.rays + i] = results.feature[c][i] + (results.transmittance[i] == 1.0F ? 5.0F : 0.0F);
    }
  }
  EXPECT_EQ(pass.image_loss(RayValues(rays, truth, 3), {1.0, 0.0, 0.0}).absolute, 0.0);
}

}  // namespace
}  // namespace simuli
