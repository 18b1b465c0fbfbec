// What a recorded picture shows of the surfaces that are seen from beside it, against the same pixel by
// pixel.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

constexpr int kWidth = 96, kHeight = 54;
constexpr double kSettled_px = 0.05;  // of the search for the time of a rolling shutter

/// The set's surfaces as a camera sees them.
struct Seen {
  View view;
  RayResults rays;
  [[nodiscard]] Pose scene_from_camera(const Camera& camera, const Eigen::Vector2d& pixel) const {
    return interpolate(
        view.scene_from_sensor_start, view.scene_from_sensor_end, camera.exposure_fraction(pixel));
  }
  /// m; negative where there is none alone.
  [[nodiscard]] double surface_m(std::size_t pixel) const {
    return rays.transmittance[pixel] < 0.2F ? static_cast<double>(rays.expected_distance(pixel)) : -1.0;
  }
};

/// Where the recorded picture shows what `beside` sees at a pixel; false where it doesn't, and `doubt` where
/// that is a matter of rounding.
bool shows(const Camera& camera,
           const Seen& recorded,
           const Seen& beside,
           const Eigen::Vector2d& pixel,
           std::size_t index,
           Eigen::Vector2d& found,
           bool& doubt) {
  doubt = std::abs(beside.rays.transmittance[index] - 0.2F) < 1e-4F;
  const double far_m = beside.surface_m(index);
  if (far_m < 0.0) return false;
  const Pose from = beside.scene_from_camera(camera, pixel);
  const Eigen::Vector3d p = from * Eigen::Vector3d(far_m * camera.unproject(pixel));
  Eigen::Vector3d in_camera;
  found = {0.5 * camera.width, 0.5 * camera.height};
  for (int k = 0; k < 20; ++k) {
    in_camera = recorded.scene_from_camera(camera, found).inverse() * p;
    if (!camera.project(in_camera, found)) return false;
  }
  doubt = doubt || std::abs(found.x() - std::round(found.x())) < kSettled_px ||
          std::abs(found.y() - std::round(found.y())) < kSettled_px;
  if (!(found.x() >= 0.0 && found.x() < camera.width && found.y() >= 0.0 && found.y() < camera.height))
    return false;
  const auto at = static_cast<std::size_t>(found.y()) * static_cast<std::size_t>(camera.width) +
                  static_cast<std::size_t>(found.x());
  doubt = doubt || std::abs(recorded.rays.transmittance[at] - 0.2F) < 1e-4F;
  const double there_m = recorded.surface_m(at), away_m = in_camera.norm();
  const double gap = std::abs(there_m - away_m) / away_m;
  doubt = doubt || std::abs(gap - 0.03) < 1e-3;
  return there_m > 0.0 && gap <= 0.03;
}

class FromBeside : public testing::TestWithParam<test::SceneCase> {};

TEST_P(FromBeside, SurfacesHaveTheColoursThatThePictureHasOfThem) {
  const Device device = Device::best();
  const RenderOptions options;
  Renderer renderer(device, options);
  const test::Shot shot = test::shot_of(GetParam(), kWidth, kHeight);
  const Camera& camera = shot.camera;
  const SensorRays rays = shot.on(device, options);
  const ParticleBuffers particles(
      device,
      test::set_for(
          GetParam(),
          {.count = 400, .scale_min = 0.2, .scale_max = 1.0, .opacity_min = 0.8, .opacity_max = 0.99},
          11),
      Precision::kFloat);
  // Colours that tell where a pixel is, so that those between pixels are what they should be; some unknown.
  const std::size_t pixels = rays.grid().rays;
  std::vector<float> picture(3 * pixels);
  std::vector<bool> is_known(pixels, true);
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto x = static_cast<float>(i % kWidth), y = static_cast<float>(i / kWidth);
    is_known[i] = x > 10.0F || y > 10.0F;
    picture[i] = is_known[i] ? (x + 0.5F) / kWidth : -1.0F;
    picture[pixels + i] = is_known[i] ? (y + 0.5F) / kHeight : -1.0F;
    picture[2 * pixels + i] = is_known[i] ? 0.25F : -1.0F;
  }
  Seen recorded{shot.view, {}}, beside{shot.view, {}};
  const Pose aside{Eigen::Quaterniond::Identity(), {0.15, 0.05, 0.0}};
  beside.view.scene_from_sensor_start = beside.view.scene_from_sensor_start * aside;
  beside.view.scene_from_sensor_end = beside.view.scene_from_sensor_end * aside;

  SeenSurfaces surfaces(device, Precision::kFloat);
  Pass there = renderer.render(particles, rays, recorded.view);
  recorded.rays = there.results();
  there.keep_surfaces(surfaces);
  RayValues shown(rays, 3, "shown");
  Pass here = renderer.render(particles, rays, beside.view);
  beside.rays = here.results();
  here.show_from(surfaces, RayValues(rays, picture, 3), shown);

  const std::vector<double> found = test::by_ray(rays, shown.slots().download_double());
  std::size_t told = 0, hidden = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const Eigen::Vector2d pixel(static_cast<double>(i % kWidth) + 0.5, static_cast<double>(i / kWidth) + 0.5);
    Eigen::Vector2d at(0.0, 0.0);
    bool doubt = false;
    const bool is_shown = shows(camera, recorded, beside, pixel, i, at, doubt);
    const double inner_x = std::clamp(at.x(), 0.5, kWidth - 0.5);
    const double inner_y = std::clamp(at.y(), 0.5, kHeight - 0.5);
    if (doubt) continue;
    const bool by_unknown = is_shown && inner_x < 12.0 && inner_y < 12.0;
    if (by_unknown) continue;
    if (!is_shown) {
      EXPECT_EQ(found[i], -1.0) << i;
      ++hidden;
      continue;
    }
    ++told;
    EXPECT_NEAR(found[i] * kWidth, inner_x, kSettled_px) << i;
    EXPECT_NEAR(found[pixels + i] * kHeight, inner_y, kSettled_px) << i;
    EXPECT_NEAR(found[2 * pixels + i], 0.25, 1e-6) << i;
  }
  EXPECT_GT(told, pixels / 20);
  EXPECT_GT(hidden, pixels / 20);
}

INSTANTIATE_TEST_SUITE_P(Of,
                         FromBeside,
                         testing::Values(test::kCameraStill, test::kCameraRolling),
                         [](const auto& of) { return of.param.name; });

TEST(FromBesideMisused, IsRefused) {
  const Device device = Device::best();
  Renderer renderer(device, {});
  const test::Shot lidar = test::shot_of(test::kLidarStill, 24, 6);
  const test::Shot camera = test::shot_of(test::kCameraStill, 32, 18);
  const SensorRays of_lidar = lidar.on(device, {}), of_camera = camera.on(device, {});
  const ParticleBuffers particles(
      device, test::set_for(test::kLidarStill, {.count = 5}, 3), Precision::kFloat);
  SeenSurfaces surfaces(device, Precision::kFloat);
  expect_error(ErrorKind::kUsage, "a LiDAR's frame", [&] {
    renderer.render(particles, of_lidar, lidar.view).keep_surfaces(surfaces);
  });
  RayValues shown(of_camera, 3, "shown");
  const RayValues picture(of_camera, std::vector<float>(3 * of_camera.grid().rays, 0.5F), 3);
  expect_error(ErrorKind::kUsage, "surfaces of another camera", [&] {
    renderer.render(particles, of_camera, camera.view).show_from(surfaces, picture, shown);
  });
}

}  // namespace
}  // namespace simuli
