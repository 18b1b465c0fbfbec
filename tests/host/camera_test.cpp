#include "host/core/sensors/camera.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

constexpr double kPixelRounding = 1e-9;  // double arithmetic on pixels of size 1e3
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Camera wide() { return {"wide", 640, 360, 500.0, 510.0, 322.0, 177.5, ShutterKind::kGlobal}; }

TEST(Camera, UnprojectThenProjectReturnsThePixel) {
  const Camera camera = wide();
  for (double y = 0.5; y < camera.height; y += 51.3) {
    for (double x = 0.5; x < camera.width; x += 47.1) {
      const Eigen::Vector3d ray = camera.unproject({x, y});
      EXPECT_NEAR(ray.norm(), 1.0, 1e-12);
      Eigen::Vector2d pixel;
      ASSERT_TRUE(camera.project(7.5 * ray, pixel));
      EXPECT_NEAR(pixel.x(), x, kPixelRounding);
      EXPECT_NEAR(pixel.y(), y, kPixelRounding);
    }
  }
}

TEST(Camera, AxesFollowOpenCv) {
  const Camera camera = wide();
  Eigen::Vector2d centre;
  Eigen::Vector2d right_down;
  ASSERT_TRUE(camera.project({0, 0, 2}, centre));
  EXPECT_NEAR(centre.x(), 322.0, kPixelRounding);
  EXPECT_NEAR(centre.y(), 177.5, kPixelRounding);
  ASSERT_TRUE(camera.project({0.2, 0.1, 2}, right_down));
  EXPECT_NEAR(right_down.x(), 372.0, kPixelRounding);
  EXPECT_NEAR(right_down.y(), 203.0, kPixelRounding);
}

TEST(Camera, ViewAngleIsWhatThePictureSpans) {
  constexpr double kDeg = std::numbers::pi / 180.0;
  // 45 degrees to the left, 26.565 (tan 1/2) to the right; 45 up and down.
  Camera camera{"c", 150, 200, 100.0, 100.0, 100.0, 100.0};
  EXPECT_NEAR(view_angle(camera).horizontal_rad, 45.0 * kDeg + std::atan(0.5), 1e-12);
  EXPECT_NEAR(view_angle(camera).vertical_rad, 90.0 * kDeg, 1e-12);
  // 960 px to either side at 600 px per rad are 183.3 degrees, but the lens ends at 90 degrees to either
  // side.
  EXPECT_NEAR(
      view_angle(builtin_camera("gsplat_camera_rear_fisheye_nodist")).horizontal_rad, 180.0 * kDeg, 0.01);
  // A full revolution.
  camera = {"c", 360, 90, 180.0 / std::numbers::pi, 180.0 / std::numbers::pi, 180.0, 45.0};
  camera.lens = Lens(LensKind::kEquirectangular, {});
  EXPECT_NEAR(view_angle(camera).horizontal_rad, 360.0 * kDeg, 1e-9);
  EXPECT_NEAR(view_angle(camera).vertical_rad, 90.0 * kDeg, 1e-9);
}

TEST(Camera, NothingBehindTheLensIsProjected) {
  Eigen::Vector2d pixel;
  EXPECT_FALSE(wide().project({0, 0, -1}, pixel));
  EXPECT_FALSE(wide().project({1, 1, 0}, pixel));
  EXPECT_FALSE(wide().project({1, 1, kNan}, pixel));
}

TEST(Camera, ResizedSeesTheSameRays) {
  const Camera camera = wide();
  const Camera small = camera.resized(160, 120);  // other aspect ratio: both axes scale on their own
  EXPECT_EQ(small.width, 160);
  EXPECT_EQ(small.height, 120);
  EXPECT_EQ(small.name, camera.name);
  const Eigen::Vector3d ray = camera.unproject({200.0, 90.0});
  EXPECT_LT((small.unproject({200.0 / 4.0, 90.0 / 3.0}) - ray).norm(), 1e-12);
  // The corners of the picture stay its corners.
  EXPECT_LT((small.unproject({160, 120}) - camera.unproject({640, 360})).norm(), 1e-12);
}

TEST(Camera, ExposureRunsWithTheShutter) {
  Camera camera = wide();
  const Eigen::Vector2d pixel(64.0, 90.0);  // a tenth from the left, a quarter from the top
  EXPECT_DOUBLE_EQ(camera.exposure_fraction(pixel), 0.5);
  camera.shutter = ShutterKind::kTopToBottom;
  EXPECT_DOUBLE_EQ(camera.exposure_fraction(pixel), 0.25);
  camera.shutter = ShutterKind::kBottomToTop;
  EXPECT_DOUBLE_EQ(camera.exposure_fraction(pixel), 0.75);
  camera.shutter = ShutterKind::kLeftToRight;
  EXPECT_DOUBLE_EQ(camera.exposure_fraction(pixel), 0.1);
  camera.shutter = ShutterKind::kRightToLeft;
  EXPECT_DOUBLE_EQ(camera.exposure_fraction(pixel), 0.9);
}

TEST(Camera, ShutterNamesRoundTrip) {
  for (const ShutterKind kind : {ShutterKind::kGlobal,
                                 ShutterKind::kTopToBottom,
                                 ShutterKind::kBottomToTop,
                                 ShutterKind::kLeftToRight,
                                 ShutterKind::kRightToLeft}) {
    EXPECT_EQ(shutter_from_string(to_string(kind), "f", "shutter"), kind);
  }
  expect_error(ErrorKind::kInput, "log.json: cameras[0].shutter: found \"diagonal\"", [] {
    (void)shutter_from_string("diagonal", "log.json", "cameras[0].shutter");
  });
}

TEST(Camera, ValidateNamesTheFieldThatIsWrong) {
  EXPECT_NO_THROW(validate(wide(), "log.json"));
  const auto refused = [](const char* field, auto set) {
    Camera camera = wide();
    set(camera);
    expect_error(ErrorKind::kInput, field, [&] { validate(camera, "log.json"); });
    expect_error(ErrorKind::kInput, "log.json: camera wide", [&] { validate(camera, "log.json"); });
  };
  refused("width_px", [](Camera& c) { c.width = 0; });
  refused("height_px", [](Camera& c) { c.height = 65537; });
  refused("fx_px", [](Camera& c) { c.fx = 0.0; });
  refused("fx_px", [](Camera& c) { c.fx = kNan; });
  refused("fx_px", [](Camera& c) { c.fx = 0.9e-3 * c.width; });
  refused("fy_px", [](Camera& c) { c.fy = 1.1e6 * c.height; });
  refused("fy_px", [](Camera& c) { c.fy = std::numeric_limits<double>::infinity(); });
  refused("cx_px", [](Camera& c) { c.cx = kNan; });
  refused("cy_px", [](Camera& c) { c.cy = -std::numeric_limits<double>::infinity(); });
  Camera nameless = wide();
  nameless.name.clear();
  nameless.fx = 0.0;
  expect_error(ErrorKind::kInput, "log.json: fx_px: found 0", [&] { validate(nameless, "log.json"); });
}

}  // namespace
}  // namespace simuli
