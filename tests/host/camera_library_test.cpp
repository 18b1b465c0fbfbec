// Tests built-in cameras and the parts of Camera that depend on the lens.
#include <cmath>
#include <gtest/gtest.h>
#include <iostream>

#include "host/core/base/angles.hpp"
#include "host/core/sensors/camera.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kReprojection_px = 1e-8;  // double arithmetic; 0.01 px would suffice

TEST(CameraLibrary, EveryPixelThatHasARayComesBackFromIt) {
  for (const std::string& name : builtin_camera_names()) {
    const Camera camera = builtin_camera(name);
    validate(camera, "library");
    // All pixels of small pictures, every 17th of each side of large ones from the last on.
    const int step = camera.width * camera.height <= 400'000 ? 1 : 17;
    std::size_t seen = 0, missing = 0;
    double worst = 0.0;
    for (int y = camera.height - 1; y >= 0; y -= step) {
      for (int x = camera.width - 1; x >= 0; x -= step) {
        const Vector2d pixel(x + 0.5, y + 0.5);
        const Vector3d ray = camera.unproject(pixel);
        ++seen;
        if (ray.isZero(0.0)) {
          ++missing;
          continue;
        }
        Vector2d again;
        ASSERT_TRUE(camera.project(ray, again)) << name << " " << pixel.transpose();
        worst = std::max(worst, (again - pixel).norm());
      }
    }
    EXPECT_LT(worst, kReprojection_px) << name;
    const double share = static_cast<double>(missing) / static_cast<double>(seen);
    std::cout << name << ": " << to_string(camera.lens.kind()) << ", " << 100.0 * share
              << " % of the pixels without a ray\n";
    // One picture extends beyond its fold, another beyond its vendor's maximum angle.
    if (name == "pandaset_front_camera") {
      EXPECT_NEAR(share, 0.0116, 0.002);
    } else if (name == "gsplat_camera_rear_fisheye_nodist") {
      EXPECT_NEAR(share, 0.075, 0.005);
    } else {
      EXPECT_EQ(missing, 0U) << name;
    }
  }
}

TEST(CameraLibrary, KeepsTheSourcesNumbersInOurPixelConvention) {
  const Camera panda = builtin_camera("pandaset_back_camera");
  EXPECT_EQ(panda.fx, 933.4667);
  EXPECT_EQ(panda.cx, 896.4692 + 0.5);  // PandaSet counts from the centre of the first pixel
  EXPECT_EQ(panda.shutter, ShutterKind::kTopToBottom);
  EXPECT_EQ(panda.lens.parameters()[4], 0.0067);
  const Camera wide = builtin_camera("gsplat_camera_front_wide_120fov");
  EXPECT_EQ(wide.cx, 1924.16064453125);
  // Radius in pixels of a point 1 rad off axis: the sum of the vendor's coefficients, but for c, d and e.
  Vector2d pixel;
  ASSERT_TRUE(wide.project({0.0, std::sin(1.0), std::cos(1.0)}, pixel));
  const double radius =
      1889.2742919921875 - 41.42326354980469 + 108.2840805053711 - 175.028564453125 + 61.991058349609375;
  EXPECT_NEAR(pixel.y() - 1484.1636962890625, radius, 1e-9);
  EXPECT_NE(builtin_camera_source("tum_vi_cam0").find("CC BY 4.0"), std::string::npos);
  expect_error(ErrorKind::kUsage, "camera: found \"nope\", allowed pandaset_back_camera", [] {
    (void)builtin_camera("nope");
  });
}

TEST(CameraLens, FthetaTakesPolynomialsInPixels) {
  const std::array<double, 5> b{0.0005287, 9.6e-9, -1.38e-11, 1.04e-14, -1.88e-18};  // rad per px^k
  Camera camera;
  camera.name = "inverse";
  camera.width = 3840;
  camera.height = 2160;
  camera.cx = 1920.0;
  camera.cy = 1080.0;
  set_ftheta(camera, LensKind::kFthetaInverse, b, {1.0, 0.0, 0.0}, kPi);
  EXPECT_NEAR(camera.fx, 1.0 / b[0], 1e-9);
  EXPECT_NEAR(camera.focal_px(), 1.0 / b[0], 1e-9);
  for (const double radius_px : {10.0, 700.0, 1900.0}) {
    double angle = 0.0;
    for (std::size_t k = 5; k-- > 0;) angle = radius_px * (b[k] + angle);
    Vector2d pixel;
    ASSERT_TRUE(camera.project({std::sin(angle), 0.0, std::cos(angle)}, pixel));
    EXPECT_NEAR(pixel.x(), 1920.0 + radius_px, 1e-8);
  }
  expect_error(ErrorKind::kInput, "camera inverse: b1: found -1", [&] {
    set_ftheta(camera, LensKind::kFthetaInverse, {-1, 0, 0, 0, 0}, {1, 0, 0}, kPi);
  });
}

TEST(CameraLens, ResizedSeesTheSameRays) {
  for (const char* const name : {"pandaset_left_camera",
                                 "tum_vi_cam1",
                                 "gsplat_camera_cross_left_120fov",
                                 "basalt_euroc_ds_calib_cam0"}) {
    const Camera camera = builtin_camera(name);
    const Camera small = camera.resized(camera.width / 4, camera.height / 8);
    const Vector2d pixel(0.3 * camera.width, 0.7 * camera.height);
    const Vector3d ray = camera.unproject(pixel);
    EXPECT_NEAR(ray.norm(), 1.0, 1e-12);
    EXPECT_LT((small.unproject({pixel.x() / 4.0, pixel.y() / 8.0}) - ray).norm(), 1e-12) << name;
  }
}

TEST(CameraLens, AnEquirectangularPictureIsOneTurnWide) {
  Camera camera;
  camera.name = "pano";
  camera.width = 360;
  camera.height = 180;
  camera.fx = camera.fy = 180.0 / kPi;  // 1 px per degree
  camera.cx = 180.0;
  camera.cy = 90.0;
  camera.lens = Lens(LensKind::kEquirectangular, {});
  validate(camera, "f");
  EXPECT_EQ(pixels_without_ray(camera), 0U);
  Vector2d pixel;
  ASSERT_TRUE(camera.project({-1e-3, 0.0, -1.0}, pixel));  // just left of straight behind
  EXPECT_NEAR(pixel.x(), 0.0573, 1e-4);
  ASSERT_TRUE(camera.project({1e-3, 0.0, -1.0}, pixel));
  EXPECT_NEAR(pixel.x(), 360.0 - 0.0573, 1e-4);
  camera.cx = 30.0;  // any azimuth may be in the middle
  ASSERT_TRUE(camera.project({-1.0, 0.0, 0.0}, pixel));
  EXPECT_NEAR(pixel.x(), 300.0, 1e-9);
  camera.shutter = ShutterKind::kLeftToRight;
  expect_error(ErrorKind::kInput, "camera pano: shutter", [&] { validate(camera, "f"); });
  camera.shutter = ShutterKind::kGlobal;
  camera.fx = 100.0;
  expect_error(ErrorKind::kInput, "camera pano: fx_px: found 100", [&] { validate(camera, "f"); });
}

}  // namespace
}  // namespace simuli
