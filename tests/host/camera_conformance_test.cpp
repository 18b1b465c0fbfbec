// Tests cameras against OpenCV 4.6 and parameters of real sensors. Skipped without SIMULI_DATA.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/host/opencv_cameras.hpp"

namespace simuli {
namespace {

TEST(CameraConformance, DoublePathMatchesOpenCv) {
  const auto cases = test::opencv_cameras();
  if (cases.empty()) GTEST_SKIP() << "not run: projections by OpenCV of 39 cameras, SIMULI_DATA is not set";
  constexpr double kDouble_px = 1e-8;
  std::size_t compared = 0, past = 0;
  for (const test::OpencvCamera& c : cases) {
    for (std::size_t i = 0; i < c.points.size(); ++i) {
      const Eigen::Vector3d& p = c.points[i];
      Eigen::Vector2d pixel;
      const bool accepted = c.camera.project(p, pixel);
      if (c.off_axis_deg(i) > c.fold_deg + test::kFoldRounding_deg) {
        EXPECT_FALSE(accepted) << c.camera.name << " point " << i;
        ++past;
      } else if (c.off_axis_deg(i) < c.fold_deg - test::kFoldRounding_deg) {
        ASSERT_TRUE(accepted) << c.camera.name << " point " << i;
        EXPECT_LT((pixel - c.pixels[i]).norm(), kDouble_px) << c.camera.name << " point " << i;
        EXPECT_LT((c.camera.unproject(pixel) - p.normalized()).norm(), 1e-9) << c.camera.name;
        ++compared;
      }
    }
    // The file has few points beyond a fold: adds more.
    for (double degrees = c.fold_deg + test::kFoldRounding_deg; degrees < 84.0; degrees += 0.5) {
      const double radius = std::tan(degrees * std::numbers::pi / 180.0);
      for (double direction = 0.0; direction < 6.28; direction += 0.3) {
        Eigen::Vector2d pixel;
        EXPECT_FALSE(c.camera.project({radius * std::cos(direction), radius * std::sin(direction), 1}, pixel))
            << c.camera.name << " at " << degrees;
        ++past;
      }
    }
  }
  EXPECT_EQ(cases.size(), 39U);
  EXPECT_GE(compared, 1500U);
  EXPECT_GE(past, 1000U);
  RecordProperty("compared", static_cast<int>(compared));
}

TEST(CameraConformance, ParametersOfRealSensorsGiveRays) {
  const char* const data = std::getenv("SIMULI_DATA");
  if (data == nullptr) GTEST_SKIP() << "not run: parameters of real sensors, SIMULI_DATA is not set";
  constexpr double kReprojection_px = 1e-8;
  const auto folder = std::filesystem::path(data) / "conformance" / "gsplat_sensors_test_data";
  int cameras = 0;
  for (const char* const file : {"test_fisheye_camera_params.json",
                                 "test_ftheta_camera_params.json",
                                 "test_pinhole_camera_params.json"}) {
    std::ifstream stream(folder / file);
    const auto root = nlohmann::json::parse(stream);
    for (const auto& [name, entry] : root.items()) {
      const auto& in = entry["intrinsics"];
      Camera camera;
      camera.name = name;
      camera.width = entry["resolution"][0];
      camera.height = entry["resolution"][1];
      camera.cx = in["principal_point"][0];
      camera.cy = in["principal_point"][1];
      std::vector<Camera> variants;
      if (entry["camera_model_type"] == "ftheta") {
        const std::array<double, 3> cde = in["linear_cde"];
        for (const bool inverse : {false, true}) {
          const std::vector<double> poly =
              in[inverse ? "pixeldist_to_angle_poly" : "angle_to_pixeldist_poly"];
          variants.push_back(camera);
          set_ftheta(variants.back(),
                     inverse ? LensKind::kFthetaInverse : LensKind::kFtheta,
                     {poly[1], poly[2], poly[3], poly[4], poly[5]},
                     cde,
                     in["max_angle_rad"]);
        }
      } else {
        camera.fx = in["focal_length"][0];
        camera.fy = in["focal_length"][1];
        std::vector<double> p;
        if (entry["camera_model_type"] == "opencv-fisheye") {
          p = in["forward_poly"].get<std::vector<double>>();
          p.push_back(in["max_angle_rad"]);
          camera.lens = Lens(LensKind::kOpencvFisheye, p);
        } else {
          const std::vector<double> k = in["radial_coeffs"], t = in["tangential_coeffs"],
                                    s = in["thin_prism_coeffs"];
          p = {k[0], k[1], t[0], t[1], k[2], k[3], k[4], k[5], s[0], s[1], s[2], s[3], std::numbers::pi};
          camera.lens = Lens(LensKind::kOpencvPinhole, p);
        }
        variants.push_back(camera);
      }
      for (const Camera& c : variants) {
        ++cameras;
        std::size_t rays = 0, seen = 0;
        for (double y = 0.5; y < c.height; y += 37.0) {
          for (double x = 0.5; x < c.width; x += 41.0) {
            ++seen;
            const Eigen::Vector3d ray = c.unproject({x, y});
            if (ray.isZero(0.0)) continue;
            ++rays;
            Eigen::Vector2d pixel;
            ASSERT_TRUE(c.project(ray, pixel)) << name;
            ASSERT_LT((pixel - Eigen::Vector2d(x, y)).norm(), kReprojection_px) << name;
          }
        }
        EXPECT_GT(rays, seen * 9 / 10) << name;
      }
      if (variants.size() == 2) {
        // The vendor's two polynomials are inverse to each other within a fraction of a pixel.
        const Eigen::Vector2d edge(0.2 * camera.width, 0.3 * camera.height);
        EXPECT_LT((variants[0].unproject(edge) - variants[1].unproject(edge)).norm() * variants[0].fx, 1.0)
            << name;
      }
    }
  }
  EXPECT_GE(cameras, 15);
}

}  // namespace
}  // namespace simuli
