// Tests the colours of a recorded picture on surfaces of an off-trajectory view against a pixel-by-pixel
// computation.
#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <utility>
#include <vector>

#include "tests/cl/support.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace off_trajectory_test {

constexpr int kWidth = 96, kHeight = 54;
constexpr double kSettled_px = 0.05;  // tolerance of the search for the time of a rolling shutter

/// Surfaces of the set in a camera view.
struct Seen {
  View view;
  RayResults rays;
  [[nodiscard]] Pose scene_from_camera(const Camera& camera, const Eigen::Vector2d& pixel) const {
    return interpolate(
        view.scene_from_sensor_start, view.scene_from_sensor_end, camera.exposure_fraction(pixel));
  }
  /// Returns the distance in m; negative without a single surface.
  [[nodiscard]] double surface_m(std::size_t pixel) const {
    return rays.transmittance[pixel] < 0.2F ? static_cast<double>(rays.expected_distance(pixel)) : -1.0;
  }
};

/// Projects a point of the scene frame to `recorded`; returns false outside of its picture.
bool project(const Camera& camera,
             const Seen& recorded,
             const Eigen::Vector3d& p,
             Eigen::Vector3d& in_camera,
             Eigen::Vector2d& found) {
  found = {0.5 * camera.width, 0.5 * camera.height};
  for (int k = 0; k < 20; ++k) {
    in_camera = recorded.scene_from_camera(camera, found).inverse() * p;
    if (!camera.project(in_camera, found)) return false;
  }
  return found.x() >= 0.0 && found.x() < camera.width && found.y() >= 0.0 && found.y() < camera.height;
}

/// Whether a position is so close to another pixel that rounding may select it.
bool is_between(const Eigen::Vector2d& found) {
  return std::abs(found.x() - std::round(found.x())) < kSettled_px ||
         std::abs(found.y() - std::round(found.y())) < kSettled_px;
}

std::size_t pixel_at(const Camera& camera, const Eigen::Vector2d& found) {
  return static_cast<std::size_t>(found.y()) * static_cast<std::size_t>(camera.width) +
         static_cast<std::size_t>(found.x());
}

/// Computes the position in the recorded picture of the surface at a pixel of `beside`; returns false if it
/// is not visible, and sets `doubt` if the decision depends on rounding.
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
  const bool is_inside = project(camera, recorded, p, in_camera, found);
  doubt = doubt || is_between(found);
  if (!is_inside) return false;
  const std::size_t at = pixel_at(camera, found);
  doubt = doubt || std::abs(recorded.rays.transmittance[at] - 0.2F) < 1e-4F;
  const double there_m = recorded.surface_m(at), away_m = in_camera.norm();
  const double gap = std::abs(there_m - away_m) / away_m;
  doubt = doubt || std::abs(gap - 0.03) < 1e-3;
  return there_m > 0.0 && gap <= 0.03;
}

/// Returns the colour of the recorded picture, constant except for steps of at least 0.1, at all positions
/// along a pixel's ray without a surface in `beside`; empty if it has several colours or not all positions
/// are visible.
std::optional<float> colour_of_all(const Camera& camera,
                                   const Seen& recorded,
                                   const Seen& beside,
                                   const std::vector<float>& red,
                                   const Eigen::Vector2d& pixel,
                                   std::size_t index,
                                   bool& doubt) {
  constexpr int kLooks = 16;
  constexpr double kNearest_m = 4.0, kFarthest_m = 1e5;
  const auto near_open = [](float passes) { return std::abs(passes - 0.95F) < 1e-4F; };
  doubt = near_open(beside.rays.transmittance[index]);
  if (!(beside.rays.transmittance[index] > 0.95F)) return std::nullopt;
  const Pose from = beside.scene_from_camera(camera, pixel);
  std::optional<float> colour;
  for (int look = 0; look < kLooks; ++look) {
    const double away_m = look == 0 ? kFarthest_m : kNearest_m * (kLooks - 1) / look;
    Eigen::Vector3d in_camera;
    Eigen::Vector2d found;
    const bool is_inside =
        project(camera, recorded, from * Eigen::Vector3d(away_m * camera.unproject(pixel)), in_camera, found);
    if (!is_inside) {
      doubt = doubt || is_between(found);
      return std::nullopt;
    }
    const std::size_t at = pixel_at(camera, found);
    const float passes = recorded.rays.transmittance[at];
    const double there_m = recorded.surface_m(at), gap = there_m / in_camera.norm() - 1.03;
    doubt = doubt || near_open(passes) || std::abs(passes - 0.2F) < 1e-4F || std::abs(gap) < 1e-3;
    // Next to a step the colour is a mixture, and next to a surface the position may be on it.
    const auto x = static_cast<int>(found.x()), y = static_cast<int>(found.y());
    for (const auto& [dx, dy] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
      if (x + dx < 0 || x + dx >= kWidth || y + dy < 0 || y + dy >= kHeight) continue;
      const std::size_t next = pixel_at(camera, {x + dx + 0.5, y + dy + 0.5});
      const bool is_like = (recorded.rays.transmittance[next] > 0.95F) == (passes > 0.95F) &&
                           (recorded.surface_m(next) > 0.0) == (there_m > 0.0);
      doubt = doubt || red[next] != red[at] || (is_between(found) && (!is_like || there_m > 0.0));
    }
    if (look > 0 && gap > 0.0) continue;  // this position is empty
    if (!(passes > 0.95F)) return std::nullopt;
    if (colour && std::abs(red[at] - *colour) > 0.04F) return std::nullopt;
    if (!colour) colour = red[at];
    if (*colour < 0.0F) return std::nullopt;
  }
  return colour;
}

class FromBeside : public testing::TestWithParam<test::SceneCase> {
 protected:
  /// Two views of a set's surfaces, and the colours of one view's picture on the other's surfaces, [3][rays].
  struct Beside {
    Seen recorded, beside;
    std::vector<double> found;
  };
  [[nodiscard]] Beside show_beside(const test::SetRecipe& recipe,
                                   const std::vector<float>& picture,
                                   const Eigen::Vector3d& aside_m) const {
    const ParticleBuffers particles(device_, test::set_for(GetParam(), recipe, 11), Precision::kFloat);
    Beside out{{shot_.view, {}}, {shot_.view, {}}, {}};
    const Pose aside{Eigen::Quaterniond::Identity(), aside_m};
    out.beside.view.scene_from_sensor_start = shot_.view.scene_from_sensor_start * aside;
    out.beside.view.scene_from_sensor_end = shot_.view.scene_from_sensor_end * aside;

    Renderer renderer(device_, {});
    SeenSurfaces surfaces(device_, Precision::kFloat);
    Pass there = renderer.render(particles, rays_, out.recorded.view);
    out.recorded.rays = there.results();
    there.keep_surfaces(surfaces);
    RayValues shown(rays_, 3, "shown");
    Pass here = renderer.render(particles, rays_, out.beside.view);
    out.beside.rays = here.results();
    here.show_from(surfaces, RayValues(rays_, picture, 3), shown);
    out.found = test::by_ray(rays_, shown.slots().download_double());
    return out;
  }

  const Device device_ = test::device();
  const test::Shot shot_ = test::shot_of(GetParam(), kWidth, kHeight);
  const SensorRays rays_ = shot_.on(device_, RenderOptions());
};

TEST_P(FromBeside, SurfacesHaveTheColoursThatThePictureHasOfThem) {
  const Camera& camera = shot_.camera;
  // Colours that identify a pixel's position, so that interpolated colours are known; some unknown.
  const std::size_t pixels = rays_.grid().rays;
  std::vector<float> picture(3 * pixels);
  std::vector<bool> is_known(pixels, true);
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto x = static_cast<float>(i % kWidth), y = static_cast<float>(i / kWidth);
    is_known[i] = x > 10.0F || y > 10.0F;
    picture[i] = is_known[i] ? (x + 0.5F) / kWidth : -1.0F;
    picture[pixels + i] = is_known[i] ? (y + 0.5F) / kHeight : -1.0F;
    picture[2 * pixels + i] = is_known[i] ? 0.25F : -1.0F;
  }
  const auto [recorded, beside, found] =
      show_beside({.count = 400, .scale_min = 0.2, .scale_max = 1.0, .opacity_min = 0.8, .opacity_max = 0.99},
                  picture,
                  {0.15, 0.05, 0.0});
  std::size_t reported = 0, hidden = 0;
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
    ++reported;
    EXPECT_NEAR(found[i] * kWidth, inner_x, kSettled_px) << i;
    EXPECT_NEAR(found[pixels + i] * kHeight, inner_y, kSettled_px) << i;
    EXPECT_NEAR(found[2 * pixels + i], 0.25, 1e-6) << i;
  }
  EXPECT_GT(reported, pixels / 20);
  EXPECT_GT(hidden, pixels / 20);
}

TEST_P(FromBeside, WhereNothingStandsIsWhatIsSeenThereAtAnyDistance) {
  const Camera& camera = shot_.camera;
  // A house in front of the sky, a part of the picture unknown; the sky is slightly lighter on one side.
  const std::size_t pixels = rays_.grid().rays;
  std::vector<float> picture(3 * pixels, 0.5F);
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::size_t x = i % kWidth;
    picture[i] = x < 8 ? -1.0F : x < 30 ? 0.4F : x < 55 ? 0.41F : 0.6F;
    if (x < 8) picture[pixels + i] = picture[2 * pixels + i] = -1.0F;
  }
  const std::vector<float> red(picture.begin(), picture.begin() + static_cast<std::ptrdiff_t>(pixels));
  const auto [recorded, beside, found] =
      show_beside({.count = 25, .scale_min = 0.3, .scale_max = 1.0, .opacity_min = 0.97, .opacity_max = 0.99},
                  picture,
                  {1.0, 0.05, 0.0});
  std::size_t reported = 0, not_reported = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (beside.surface_m(i) > 0.0) continue;
    const Eigen::Vector2d pixel(static_cast<double>(i % kWidth) + 0.5, static_cast<double>(i / kWidth) + 0.5);
    bool doubt = false;
    const std::optional<float> wanted = colour_of_all(camera, recorded, beside, red, pixel, i, doubt);
    if (doubt) continue;
    ++(wanted ? reported : not_reported);
    EXPECT_NEAR(found[i], wanted ? static_cast<double>(*wanted) : -1.0, 1e-6) << i;
    EXPECT_NEAR(found[pixels + i], wanted ? 0.5 : -1.0, 1e-6) << i;
  }
  EXPECT_GT(reported, pixels / 20);
  EXPECT_GT(not_reported, pixels / 20);
}

INSTANTIATE_TEST_SUITE_P(Of,
                         FromBeside,
                         testing::Values(test::kCameraStill, test::kCameraRolling),
                         [](const auto& of) { return of.param.name; });

TEST(FromBesideMisused, IsRefused) {
  const Device& device = test::device();
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

}  // namespace off_trajectory_test
}  // namespace simuli
