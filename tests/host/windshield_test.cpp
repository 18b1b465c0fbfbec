// Tests lenses behind a windshield against an independent definition.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "host/core/base/angles.hpp"
#include "host/core/base/error.hpp"
#include "host/core/sensors/camera.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/host/windshields.hpp"

namespace simuli {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Returns the sum over j and i with i + j up to the degree.
double polynomial(const std::vector<double>& c, double a, double b) {
  int degree = 0;
  while (static_cast<std::size_t>((degree + 1) * (degree + 2) / 2) < c.size()) ++degree;
  double sum = 0.0;
  std::size_t at = 0;
  for (int j = 0; j <= degree; ++j) {
    for (int i = 0; i <= degree - j; ++i) sum += c[at++] * std::pow(a, i) * std::pow(b, j);
  }
  return sum;
}

Vector3d bent(const std::vector<double>& horizontal, const std::vector<double>& vertical, const Vector3d& d) {
  const Vector3d n = d.normalized();
  const double a = std::asin(n.x()), b = std::asin(n.y());
  const double x = std::sin(polynomial(horizontal, a, b)), y = std::sin(polynomial(vertical, a, b));
  return {x, y, std::sqrt(1.0 - x * x - y * y)};
}

Camera camera_behind(const Windshield& glass, LensKind kind, const std::vector<double>& parameters) {
  Camera camera;
  camera.name = "front";
  camera.width = 320;
  camera.height = 200;
  camera.fx = 160.0;
  camera.fy = 150.0;
  camera.cx = 161.0;
  camera.cy = 98.0;
  camera.lens = (kind == LensKind::kPinhole ? Lens() : Lens(kind, parameters)).behind(glass);
  return camera;
}

std::vector<Camera> cameras() {
  std::vector<Camera> all;
  for (const Windshield& glass : {test::glass_before_the_lens(), test::glass_by_its_way_back()}) {
    all.push_back(camera_behind(glass, LensKind::kPinhole, {}));
    all.push_back(camera_behind(glass, LensKind::kOpencvFisheye, {-0.03, -0.005, -0.0008, 0.001, 1.4}));
    all.push_back(camera_behind(
        glass, LensKind::kFthetaInverse, {1.0, 0.03, -0.08, 0.11, -0.03, 1.0002, -0.001, 0.0005, 1.3}));
  }
  return all;
}

TEST(Windshield, BendsRaysBeforeTheLensAsItsPolynomialsSay) {
  for (const Camera& camera : cameras()) {
    const Windshield& glass = *camera.lens.windshield();
    const bool is_forward = glass.reference == Windshield::Reference::kForward;
    const Lens bare = camera.lens.kind() == LensKind::kOpencvPinhole
                          ? Lens()
                          : Lens(camera.lens.kind(), camera.lens.parameters());
    int compared = 0;
    for (double x = -0.8; x <= 0.8; x += 0.1) {
      for (double y = -0.6; y <= 0.6; y += 0.1) {
        // The direction on the side from which the polynomials are exact.
        const Vector3d given = 7.0 * Vector3d(x, y, 1.0).normalized();
        const Vector3d other = is_forward ? bent(glass.horizontal, glass.vertical, given)
                                          : bent(glass.horizontal_inverse, glass.vertical_inverse, given);
        const Vector3d outside = is_forward ? given : other, inside = is_forward ? other : given;
        Vector2d expected, found;
        ASSERT_TRUE(bare.project(inside, expected));
        ASSERT_TRUE(camera.lens.project(outside, found)) << x << " " << y;
        EXPECT_LT((found - expected).norm(), 1e-12) << x << " " << y;
        ++compared;
      }
    }
    EXPECT_GT(compared, 100);
  }
}

TEST(Windshield, EveryPixelsRayComesBackToIt) {
  for (const Camera& camera : cameras()) {
    std::size_t with_ray = 0;
    for (int y = 0; y < camera.height; y += 3) {
      for (int x = 0; x < camera.width; x += 3) {
        const Vector2d pixel(x + 0.5, y + 0.5);
        const Vector3d ray = camera.unproject(pixel);
        if (ray.isZero(0.0)) continue;
        ++with_ray;
        EXPECT_NEAR(ray.norm(), 1.0, 1e-12);
        Vector2d again;
        ASSERT_TRUE(camera.project(3.0 * ray, again));
        EXPECT_LT((again - pixel).norm(), 1e-6);
      }
    }
    EXPECT_GT(with_ray, 6900U) << to_string(camera.lens.kind());  // of 7 169
  }
}

TEST(Windshield, IsSeenInPixelsAndInThePixelsPerRad) {
  const Camera bare = [] {
    Camera camera = cameras().front();
    camera.lens = Lens();
    return camera;
  }();
  const Camera camera = cameras().front();
  Vector2d with, without;
  ASSERT_TRUE(camera.project({0.3, 0.2, 1.0}, with));
  ASSERT_TRUE(bare.project({0.3, 0.2, 1.0}, without));
  EXPECT_GT((with - without).norm(), 0.5);
  EXPECT_NE(camera.lens, bare.lens);
  // d(a', b') / d(a, b) about the axis: 1.004 x 1.009 - 0.0009 x 0.0007.
  EXPECT_NEAR(camera.focal_px() / bare.focal_px(), std::sqrt(1.004 * 1.009 - 0.0009 * 0.0007), 1e-5);
}

TEST(Windshield, GlassThatBendsNothingChangesNothing) {
  const std::vector<double> a{0, 1, 0}, b{0, 0, 1};
  for (const auto reference : {Windshield::Reference::kForward, Windshield::Reference::kBackward}) {
    const Camera camera = camera_behind({reference, a, b, a, b}, LensKind::kPinhole, {});
    Vector2d found;
    ASSERT_TRUE(camera.project({0.5, -0.4, 2.0}, found));
    EXPECT_LT((found - Vector2d(161.0 + 160.0 * 0.25, 98.0 - 150.0 * 0.2)).norm(), 1e-10);
  }
}

TEST(Windshield, PointsBehindItHaveNoImage) {
  for (const Camera& camera : cameras()) {
    Vector2d pixel;
    EXPECT_FALSE(camera.project({0.1, 0.1, -1.0}, pixel));
    EXPECT_FALSE(camera.project({0.0, 0.0, 0.001}, pixel));
    EXPECT_FALSE(camera.project({std::nan(""), 0.0, 1.0}, pixel));
    EXPECT_TRUE(camera.unproject({1e9, 0.0}).isZero(0.0));
  }
}

TEST(Windshield, RefusesWhatNoGlassDoes) {
  const Windshield good = test::glass_before_the_lens();
  const auto refused = [&](const std::function<void(Windshield&)>& change, const std::string& words) {
    Windshield glass = good;
    change(glass);
    expect_error(ErrorKind::kInput, words, [&] { (void)Lens().behind(glass, "rig.json"); });
  };
  refused([](Windshield& g) { g.horizontal.pop_back(); },
          "rig.json: windshield.horizontal: found 5 coefficients, allowed 1, 3, 6, 10, 15 or 21");
  refused([](Windshield& g) { g.vertical_inverse.clear(); },
          "windshield.vertical_inverse: found 0 coefficients");
  refused([](Windshield& g) { g.vertical[3] = std::nan(""); }, "windshield.vertical: found nan");
  // Equal polynomials for both angles: a line instead of a picture.
  refused([](Windshield& g) { g.vertical = {0, 1.01, 0, 0, 0, 0}; }, "not one to one");
  expect_error(ErrorKind::kInput, "equirectangular", [&] {
    (void)Lens(LensKind::kEquirectangular, {}).behind(good, "rig.json");
  });
}

TEST(Windshield, EndsWhereItsPolynomialsFold) {
  // a' = a - a^3: its slope is 0 at asin(x) = sqrt(1 / 3).
  const std::vector<double> b{0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
  const std::vector<double> a{0, 1, 0, -1, 0, 0, 0, 0, 0, 0};
  const std::vector<double> back_a{0, 1, 0}, back_b{0, 0, 1};
  const Lens lens = Lens().behind({Windshield::Reference::kForward, a, b, back_a, back_b});
  Vector2d image;
  const double fold = std::sqrt(1.0 / 3.0);
  EXPECT_TRUE(lens.project({std::sin(fold - 0.01), 0.0, std::cos(fold - 0.01)}, image));
  EXPECT_FALSE(lens.project({std::sin(fold + 0.001), 0.0, std::cos(fold + 0.001)}, image));
}

}  // namespace
}  // namespace simuli
