// Where units and conventions of lenses differ: pixel centres, degrees of polynomials, sizes, shutters.
#include "host/apps/serve/messages/camera_message.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "host/apps/serve/messages/render_message.hpp"
#include "tests/host/windshields.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::serve {
namespace {

using test::expect_refusal;

proto::CameraSpec some_spec() {
  proto::CameraSpec spec;
  spec.set_logical_id("front");
  spec.set_resolution_w(640);
  spec.set_resolution_h(360);
  spec.set_shutter_type(proto::GLOBAL);
  return spec;
}

/// Radius 500 t - 20 t^3 px about (319.5, 179.5), told with coefficients of degree 0 to 3.
proto::CameraSpec ftheta_spec() {
  proto::CameraSpec spec = some_spec();
  auto& p = *spec.mutable_ftheta_param();
  p.set_principal_point_x(319.5);
  p.set_principal_point_y(179.5);
  p.set_reference_poly(proto::FthetaCameraParam::ANGLE_TO_PIXELDIST);
  for (const double c : {0.0, 500.0, 0.0, -20.0}) p.add_angle_to_pixeldist_poly(c);
  return spec;
}

Eigen::Vector2d pixel_of(const Camera& camera, const Eigen::Vector3d& point) {
  Eigen::Vector2d pixel = Eigen::Vector2d::Constant(-1.0);
  EXPECT_TRUE(camera.project(point, pixel));
  return pixel;
}

/// A direction at that angle off the axis, in the plane of x and y at `turn` rad from x.
Eigen::Vector3d direction(double angle, double turn) {
  return {std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), std::cos(angle)};
}

TEST(CameraMessage, CountsFthetaPixelsFromTheCentreOfTheFirst) {
  const Camera camera = camera_of(ftheta_spec());
  EXPECT_EQ(camera.cx, 320.0);
  EXPECT_EQ(camera.cy, 180.0);
  const double angle = 0.3, turn = 0.7, radius = 500.0 * angle - 20.0 * std::pow(angle, 3);
  const Eigen::Vector2d pixel = pixel_of(camera, 7.0 * direction(angle, turn));
  EXPECT_NEAR(pixel.x(), 320.0 + radius * std::cos(turn), 1e-9);
  EXPECT_NEAR(pixel.y(), 180.0 + radius * std::sin(turn), 1e-9);
}

TEST(CameraMessage, CountsOtherPixelsFromTheCorner) {
  proto::CameraSpec spec = some_spec();
  auto& p = *spec.mutable_opencv_pinhole_param();
  p.set_principal_point_x(319.5);
  p.set_principal_point_y(179.5);
  p.set_focal_length_x(400.0);
  p.set_focal_length_y(410.0);
  const Camera camera = camera_of(spec);
  EXPECT_EQ(pixel_of(camera, {0.1, 0.2, 1.0}), Eigen::Vector2d(319.5 + 40.0, 179.5 + 82.0));
}

TEST(CameraMessage, TakesTheReferencePolynomial) {
  proto::CameraSpec spec = ftheta_spec();
  auto& p = *spec.mutable_ftheta_param();
  for (const double c : {0.0, 1.0}) p.add_pixeldist_to_angle_poly(c);  // nonsense, and not the reference
  EXPECT_EQ(camera_of(spec), camera_of(ftheta_spec()));
  // The inverse the other way round: t = radius / 500.
  p.set_reference_poly(proto::FthetaCameraParam::PIXELDIST_TO_ANGLE);
  p.set_pixeldist_to_angle_poly(1, 1.0 / 500.0);
  const Eigen::Vector2d pixel = pixel_of(camera_of(spec), direction(0.3, 0.0));
  EXPECT_NEAR(pixel.x(), 320.0 + 150.0, 1e-9);
  p.set_reference_poly(proto::FthetaCameraParam::UNKNOWN);
  expect_refusal(RefusalKind::kInvalid, "reference_poly", [&] { static_cast<void>(camera_of(spec)); });
}

TEST(CameraMessage, TakesFewCoefficientsAndNoOffset) {
  proto::CameraSpec spec = ftheta_spec();
  auto& polynomial = *spec.mutable_ftheta_param()->mutable_angle_to_pixeldist_poly();
  polynomial.Clear();
  for (const double c : {0.0, 500.0}) polynomial.Add(c);
  EXPECT_NEAR(pixel_of(camera_of(spec), direction(0.4, 0.0)).x(), 320.0 + 200.0, 1e-9);
  polynomial.Set(0, 0.1);
  expect_refusal(RefusalKind::kInvalid, "degree 0", [&] { static_cast<void>(camera_of(spec)); });
  polynomial.Set(0, 0.0);
  for (int i = 0; i < 5; ++i) polynomial.Add(0.0);
  expect_refusal(RefusalKind::kInvalid, "7 coefficients", [&] { static_cast<void>(camera_of(spec)); });
}

TEST(CameraMessage, TakesNoLargestAngleForNone) {
  proto::CameraSpec spec = some_spec();
  auto& p = *spec.mutable_opencv_fisheye_param();
  p.set_principal_point_x(320);
  p.set_principal_point_y(180);
  p.set_focal_length_x(100);
  p.set_focal_length_y(100);
  EXPECT_NEAR(pixel_of(camera_of(spec), direction(1.5, 0.0)).x(), 320.0 + 150.0, 1e-9);
  p.set_max_angle(1.0);
  Eigen::Vector2d pixel;
  EXPECT_FALSE(camera_of(spec).project(direction(1.5, 0.0), pixel));
  EXPECT_TRUE(camera_of(spec).project(direction(0.9, 0.0), pixel));
}

TEST(CameraMessage, OrdersDistortionAsTheProtocolDoes) {
  proto::CameraSpec spec = some_spec();
  auto& p = *spec.mutable_opencv_pinhole_param();
  p.set_focal_length_x(1.0);
  p.set_focal_length_y(1.0);
  const double k[] = {0.1, 0.02, 0.003, 0.05, 0.006, 0.0007}, t[] = {0.001, 0.002},
               s[] = {0.003, 0.004, 0.005, 0.006};
  for (const double c : k) p.add_radial_coeffs(c);
  for (const double c : t) p.add_tangential_coeffs(c);
  for (const double c : s) p.add_thin_prism_coeffs(c);
  const double x = 0.2, y = -0.1, r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial = (1 + k[0] * r2 + k[1] * r4 + k[2] * r6) / (1 + k[3] * r2 + k[4] * r4 + k[5] * r6);
  const double u = x * radial + 2 * t[0] * x * y + t[1] * (r2 + 2 * x * x) + s[0] * r2 + s[1] * r4;
  const double v = y * radial + t[0] * (r2 + 2 * y * y) + 2 * t[1] * x * y + s[2] * r2 + s[3] * r4;
  const Eigen::Vector2d pixel = pixel_of(camera_of(spec), {x, y, 1.0});
  EXPECT_NEAR(pixel.x(), u, 1e-12);
  EXPECT_NEAR(pixel.y(), v, 1e-12);
}

TEST(CameraMessage, RefusesWhatNoCameraHas) {
  const auto refused = [](const std::string& part, const std::function<void(proto::CameraSpec&)>& spoil) {
    proto::CameraSpec spec = ftheta_spec();
    spoil(spec);
    expect_refusal(RefusalKind::kInvalid, part, [&] { static_cast<void>(camera_of(spec)); });
  };
  refused("shutter_type", [](auto& s) { s.set_shutter_type(proto::UNKNOWN); });
  refused("resolution_h", [](auto& s) { s.set_resolution_h(0); });
  refused("resolution_w", [](auto& s) { s.set_resolution_w(100000); });
  refused("camera_param", [](auto& s) { s.clear_camera_param(); });
  refused("cx_px", [](auto& s) { s.mutable_ftheta_param()->set_principal_point_x(NAN); });
  refused("a1", [](auto& s) { s.mutable_ftheta_param()->set_angle_to_pixeldist_poly(1, -500.0); });
  refused("max_angle", [](auto& s) { s.mutable_ftheta_param()->set_max_angle(-1.0); });
  proto::CameraSpec behind_glass = ftheta_spec();
  behind_glass.mutable_bivariate_windshield_model_param()->set_reference_poly(
      static_cast<proto::BivariateWindshieldModelParameters::ReferencePolynomial>(7));
  expect_refusal(
      RefusalKind::kInvalid, "reference_poly", [&] { static_cast<void>(camera_of(behind_glass)); });
  behind_glass.mutable_bivariate_windshield_model_param()->clear_reference_poly();
  EXPECT_THROW(static_cast<void>(camera_of(behind_glass)), Error);  // without polynomials
}

TEST(CameraMessage, WindshieldsComeBackAsTheyAre) {
  for (const Windshield& glass : {test::glass_before_the_lens(), test::glass_by_its_way_back()}) {
    Camera camera = camera_of(ftheta_spec());
    camera.lens = camera.lens.behind(glass);
    const Camera back = camera_of(spec_of(camera));
    ASSERT_TRUE(back.lens.windshield());
    EXPECT_EQ(*back.lens.windshield(), glass);
    EXPECT_LT((pixel_of(back, {0.3, -0.2, 1.0}) - pixel_of(camera, {0.3, -0.2, 1.0})).norm(), 1e-9);
  }
}

using ServedCameras = test::Served;

TEST_F(ServedCameras, ComeBackAsTheyAre) {
  for (const Sensor& sensor : scene_->cameras()) {
    const Camera& camera = sensor.camera();
    proto::RGBRenderRequest request;
    request.set_resolution_w(static_cast<std::uint32_t>(camera.width));
    request.set_resolution_h(static_cast<std::uint32_t>(camera.height));
    *request.mutable_camera_intrinsics() = spec_of(camera);
    EXPECT_EQ(requested_camera(*scene_, request), camera) << camera.name;
    // By its name alone, too: lenses that the protocol lacks have no other way.
    request.mutable_camera_intrinsics()->Clear();
    request.mutable_camera_intrinsics()->set_logical_id(camera.name);
    EXPECT_EQ(requested_camera(*scene_, request), camera) << camera.name;
    if (camera.name == "mirror") continue;
    // What the message says is the same camera within rounding, whatever it is called.
    proto::CameraSpec renamed = spec_of(camera);
    renamed.set_logical_id("other");
    const Camera reported = camera_of(renamed);
    for (const double angle : {0.0, 0.2, 0.5}) {
      for (const double turn : {0.0, 1.0, 4.0}) {
        const Eigen::Vector3d point = 3.0 * direction(angle, turn);
        EXPECT_LT((pixel_of(reported, point) - pixel_of(camera, point)).norm(), 1e-9) << camera.name;
      }
    }
  }
}

TEST_F(ServedCameras, AreScaledOnEachAxisByItself) {
  proto::RGBRenderRequest request;
  request.set_resolution_w(320);
  request.set_resolution_h(270);
  *request.mutable_camera_intrinsics() = ftheta_spec();
  const Camera whole = camera_of(ftheta_spec()), scaled = requested_camera(*scene_, request);
  EXPECT_EQ(scaled.width, 320);
  EXPECT_EQ(scaled.height, 270);
  for (const double angle : {0.0, 0.1, 0.3}) {
    const Eigen::Vector3d point = direction(angle, 0.6);
    const Eigen::Vector2d wanted = pixel_of(whole, point).cwiseProduct(Eigen::Vector2d(0.5, 0.75));
    EXPECT_LT((pixel_of(scaled, point) - wanted).norm(), 1e-9);
  }
  // Told again with its new size, it is the same camera: the linear part holds the aspect.
  proto::CameraSpec reported = spec_of(scaled);
  reported.set_logical_id("other");
  EXPECT_NEAR(reported.ftheta_param().linear_cde().linear_c(), 0.5 / 0.75, 1e-12);
  EXPECT_LT(
      (pixel_of(camera_of(reported), direction(0.3, 0.6)) - pixel_of(scaled, direction(0.3, 0.6))).norm(),
      1e-9);
  reported.set_logical_id("");  // which a request need not have, but a Sensor
  EXPECT_NO_THROW((void)Sensor(camera_of(reported)));
  for (const auto& [width, height] : {std::pair{0U, 270U}, {320U, 0U}, {100000U, 100000U}, {5000U, 5000U}}) {
    request.set_resolution_w(width);
    request.set_resolution_h(height);
    expect_refusal(
        RefusalKind::kInvalid, "resolution", [&] { static_cast<void>(requested_camera(*scene_, request)); });
  }
}

}  // namespace
}  // namespace simuli::serve
