// Tests each lens and the limits of its domain against independently written formulas.
#include "host/core/sensors/lens.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "cl/shared/sensor_constants.h"
#include "host/core/base/angles.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Rounding of two ways to write one formula, values of size 1 to 10.
constexpr double kSameFormula = 1e-12;
// Past this step off a fold (relative) the sign of a finite difference is certain.
constexpr double kFoldStep = 1e-3;

Vector3d at(double angle, double direction) {
  return {std::sin(angle) * std::cos(direction), std::sin(angle) * std::sin(direction), std::cos(angle)};
}

Vector2d image_of(const Lens& lens, const Vector3d& p) {
  Vector2d image(1e9, 1e9);
  EXPECT_TRUE(lens.project(p, image)) << p.transpose();
  return image;
}

bool has_image(const Lens& lens, const Vector3d& p) {
  Vector2d image;
  return lens.project(p, image);
}

/// Expects that directions up to `max_angle` round-trip; returns their number.
int expect_round_trips(const Lens& lens, double max_angle) {
  constexpr double kRoundTrip_rad = 2e-8;  // near a fold the image hardly moves: half the digits
  int count = 0;
  for (double angle = 0.0; angle < max_angle; angle += 0.0371) {
    for (double direction = 0.05; direction < 2.0 * kPi; direction += 0.37) {
      const Vector3d d = at(angle, direction);
      Vector2d image;
      if (!lens.project(3.0 * d, image)) continue;
      EXPECT_LT((lens.unproject(image) - d).norm(), kRoundTrip_rad) << angle << " " << direction;
      ++count;
    }
  }
  return count;
}

/// OpenCV's documentation, term by term.
Vector2d opencv_formula(const std::vector<double>& c, double x, double y) {
  const double k1 = c[0], k2 = c[1], p1 = c[2], p2 = c[3], k3 = c[4], k4 = c[5], k5 = c[6], k6 = c[7];
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double radial = (1 + k1 * r2 + k2 * r4 + k3 * r6) / (1 + k4 * r2 + k5 * r4 + k6 * r6);
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + c[8] * r2 + c[9] * r4,
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + c[10] * r2 + c[11] * r4};
}

const std::vector<double> kRational{
    0.55, -2.6, 0.001, -0.0006, 1.5, 0.42, -2.4, 1.43, 0.002, -0.0005, -0.0015, 0.0007, kPi};
// The radius grows up to 35 degrees off axis and falls from there on: inside a picture of usual width.
const std::vector<double> kFolded{-0.5894, 0.66, 0.0011, -0.001, -1.0088, 0, 0, 0, 0, 0, 0, 0, kPi};

TEST(LensOpencvPinhole, FollowsTheFormula) {
  const Lens lens(LensKind::kOpencvPinhole, kRational);
  for (double x = -0.7; x < 0.71; x += 0.1) {
    for (double y = -0.6; y < 0.61; y += 0.1) {
      const Vector2d expected = opencv_formula(kRational, x, y);
      EXPECT_LT((image_of(lens, 4.0 * Vector3d(x, y, 1.0)) - expected).norm(), kSameFormula) << x << " " << y;
    }
  }
  EXPECT_GT(expect_round_trips(lens, 0.75), 300);
  EXPECT_FALSE(has_image(lens, {0.0, 0.0, -1.0}));
  EXPECT_FALSE(has_image(lens, {0.0, 0.0, 0.009}));  // nearer than 1 cm
}

// Flat to rounding in all 128 directions; a search for folds at each of its samples took seconds.
TEST(LensOpencvPinhole, HardlyAnyDistortionIsNone) {
  std::vector<double> hardly(kFolded.size(), 0.0);
  hardly.back() = kPi;
  const Lens none(LensKind::kOpencvPinhole, hardly);
  for (const double p1 : {1e-300, 1e-20, 1e-17}) {
    hardly[2] = p1;
    const Lens lens(LensKind::kOpencvPinhole, hardly);
    EXPECT_EQ(lens.constants().radius2_max, none.constants().radius2_max) << p1;
  }
}

TEST(LensOpencvPinhole, NothingPastTheFoldIsAcceptedAndNothingBeforeItRejected) {
  const Lens lens(LensKind::kOpencvPinhole, kFolded);
  const auto determinant = [](double r, double direction) {
    constexpr double h = 1e-6;
    const double x = r * std::cos(direction), y = r * std::sin(direction);
    const Vector2d dx = opencv_formula(kFolded, x + h, y) - opencv_formula(kFolded, x - h, y);
    const Vector2d dy = opencv_formula(kFolded, x, y + h) - opencv_formula(kFolded, x, y - h);
    return dx.x() * dy.y() - dx.y() * dy.x();
  };
  double nearest = 1e9, furthest = 0.0;
  for (double direction = 0.0; direction < 2.0 * kPi; direction += 0.05) {
    double fold = 0.0;
    while (determinant(fold, direction) > 0.0) fold += 1e-5;
    nearest = std::min(nearest, fold);
    furthest = std::max(furthest, fold);
    const Vector3d along(std::cos(direction), std::sin(direction), 0.0);
    const Vector3d before = (1.0 - kFoldStep) * fold * along + Vector3d::UnitZ();
    EXPECT_TRUE(has_image(lens, before)) << direction;
    EXPECT_LT((lens.unproject(image_of(lens, before)) - before.normalized()).norm(), 1e-7) << direction;
    for (double r = (1.0 + kFoldStep) * fold; r < 9.0; r *= 1.01) {
      EXPECT_FALSE(has_image(lens, r * along + Vector3d::UnitZ())) << direction << " " << r;
    }
  }
  EXPECT_GT(furthest, nearest * 1.001);  // the tangential terms bend the fold: one radius would not do
  // the maximum image radius is about 0.53; pixels beyond have no ray
  EXPECT_TRUE(lens.unproject({0.6, 0.0}).isZero(0.0));
  EXPECT_TRUE(lens.unproject({-0.5, 0.5}).isZero(0.0));
  EXPECT_FALSE(lens.unproject({0.3, 0.2}).isZero(0.0));
}

TEST(LensOpencvPinhole, APoleOfTheRationalTermEndsTheDomain) {
  std::vector<double> parameters(13, 0.0);
  parameters[5] = -1.0;  // 1 / (1 - r^2)
  parameters[12] = kPi;
  const Lens lens(LensKind::kOpencvPinhole, parameters);
  EXPECT_TRUE(has_image(lens, {0.99, 0.0, 1.0}));
  EXPECT_FALSE(has_image(lens, {1.01, 0.0, 1.0}));
  EXPECT_FALSE(has_image(lens, {5.0, 0.0, 1.0}));
}

TEST(LensOpencvFisheye, FollowsTheFormulaBeyondAHalfTurn) {
  const std::vector<double> k{0.02, 0.01, 0.005, 0.002, 1.9};
  const Lens lens(LensKind::kOpencvFisheye, k);
  for (double angle = 0.01; angle < 1.9; angle += 0.07) {
    const double t2 = angle * angle;
    const double radius =
        angle * (1 + k[0] * t2 + k[1] * t2 * t2 + k[2] * t2 * t2 * t2 + k[3] * t2 * t2 * t2 * t2);
    const Vector2d image = image_of(lens, 2.0 * at(angle, 0.8));
    EXPECT_LT((image - radius * Vector2d(std::cos(0.8), std::sin(0.8))).norm(), 10 * kSameFormula) << angle;
  }
  EXPECT_EQ(image_of(lens, {0.0, 0.0, 2.0}), Vector2d(0.0, 0.0));
  EXPECT_TRUE(has_image(lens, at(1.899, 0.3)));
  EXPECT_FALSE(has_image(lens, at(1.901, 0.3)));  // max_angle_rad
  EXPECT_FALSE(has_image(lens, {0.0, 0.0, -1.0}));
  EXPECT_GT(expect_round_trips(lens, 1.9), 800);
}

TEST(LensOpencvFisheye, EndsAtTheFirstRootOfTheDerivative) {
  const Lens lens(LensKind::kOpencvFisheye, {-0.1, 0.0, 0.0, 0.0, kPi});
  const double root = std::sqrt(1.0 / 0.3);  // of 1 - 0.3 t^2
  EXPECT_NEAR(lens.constants().angle_max, root, 1e-9);
  EXPECT_TRUE(has_image(lens, at(root - 1e-6, 2.0)));
  EXPECT_FALSE(has_image(lens, at(root + 1e-6, 2.0)));
  const double largest = root - 0.1 * root * root * root;
  EXPECT_FALSE(lens.unproject({0.0, largest - 1e-6}).isZero(0.0));
  EXPECT_TRUE(lens.unproject({0.0, largest + 1e-6}).isZero(0.0));
}

TEST(LensFtheta, FollowsItsPolynomialAndItsLinearTerms) {
  const std::vector<double> a{1.0, -0.02, 0.06, -0.095, 0.034, 0.9997, 0.0034, -0.002, 1.35};
  const Lens lens(LensKind::kFtheta, a);
  for (double angle = 0.02; angle < 1.34; angle += 0.06) {
    double radius = 0.0;
    for (std::size_t k = 0; k < 5; ++k) radius += a[k] * std::pow(angle, static_cast<double>(k + 1));
    const double x = radius * std::cos(2.5), y = radius * std::sin(2.5);
    const Vector2d expected(a[5] * x + a[6] * y, a[7] * x + y);
    EXPECT_LT((image_of(lens, 5.0 * at(angle, 2.5)) - expected).norm(), kSameFormula) << angle;
  }
  EXPECT_FALSE(has_image(lens, at(1.36, 0.0)));
  EXPECT_GT(expect_round_trips(lens, 1.35), 500);
}

TEST(LensFtheta, TheInverseReferenceIsSolvedToTheEnd) {
  const std::vector<double> b{1.0, 0.03, -0.08, 0.11, -0.03, 1.0002, -0.001, 0.0005, 1.3};
  const Lens lens(LensKind::kFthetaInverse, b);
  const double determinant = b[5] - b[6] * b[7];
  int seen = 0;
  for (double angle = 0.0; angle < 1.3; angle += 0.011) {
    const Vector2d image = image_of(lens, at(angle, -1.1));
    const Vector2d round((image.x() - b[6] * image.y()) / determinant,
                         (b[5] * image.y() - b[7] * image.x()) / determinant);
    double back = 0.0;
    for (std::size_t k = 5; k-- > 0;) back = round.norm() * (b[k] + back);
    EXPECT_NEAR(back, angle, kSameFormula);
    ++seen;
  }
  EXPECT_GT(seen, 100);
  EXPECT_FALSE(has_image(lens, at(1.31, 0.0)));
  EXPECT_GT(expect_round_trips(lens, 1.3), 500);
}

TEST(LensFtheta, AFoldNarrowerThanTheSearchIsFound) {
  // slope = ((t - 1)^2 - d^2) (t^2 + 1): it dips below zero for 2 d around t = 1.
  constexpr double d = 1e-4;
  const Lens lens(LensKind::kFtheta, {1 - d * d, -1.0, (2 - d * d) / 3.0, -0.5, 0.2, 1.0, 0.0, 0.0, kPi});
  EXPECT_NEAR(lens.constants().angle_max, 1.0 - d, 1e-8);
}

TEST(LensMei, FollowsTheFormulaOnBothSidesOfTheUnitMirror) {
  for (const double xi : {0.6, 2.2}) {
    const std::vector<double> p{0.017, 0.55, 0.0004, -0.0005, xi, kPi};
    const Lens lens(LensKind::kMei, p);
    for (double angle = 0.0; angle < 1.7; angle += 0.08) {
      const Vector3d d = at(angle, 0.4);
      const double x = d.x() / (d.z() + xi), y = d.y() / (d.z() + xi);
      const Vector2d expected = opencv_formula({p[0], p[1], p[2], p[3], 0, 0, 0, 0, 0, 0, 0, 0}, x, y);
      EXPECT_LT((image_of(lens, 7.0 * d) - expected).norm(), 100 * kSameFormula) << xi << " " << angle;
    }
    EXPECT_GT(expect_round_trips(lens, 1.9), 700);
    // Tangent to the mirror, or parallel to the plane: beyond it the map folds.
    const double end = std::acos(-std::min(xi, 1.0 / xi));
    EXPECT_TRUE(has_image(lens, at(end - 1e-3, 1.0)));
    EXPECT_FALSE(has_image(lens, at(end + 1e-3, 1.0)));
    EXPECT_FALSE(has_image(lens, at(kPi, 0.0)));
  }
}

TEST(LensEquirectangular, IsAzimuthAndElevation) {
  const Lens lens(LensKind::kEquirectangular, {});
  for (double azimuth = -3.1; azimuth < 3.14; azimuth += 0.31) {
    for (double elevation = -1.5; elevation < 1.51; elevation += 0.25) {
      const Vector3d d(std::cos(elevation) * std::sin(azimuth),
                       std::sin(elevation),
                       std::cos(elevation) * std::cos(azimuth));
      EXPECT_LT((image_of(lens, 0.02 * d) - Vector2d(azimuth, elevation)).norm(), kSameFormula);
      EXPECT_LT((lens.unproject({azimuth, elevation}) - d).norm(), kSameFormula);
    }
  }
  EXPECT_TRUE(lens.unproject({0.0, 1.6}).isZero(0.0));  // beyond the pole
  EXPECT_FALSE(has_image(lens, {0.0, 0.005, 0.0}));
}

TEST(LensDoubleSphere, FollowsTheFormulaUpToItsBound) {
  const double xi = -0.17, alpha = 0.593;
  const Lens lens(LensKind::kDoubleSphere, {xi, alpha, kPi});
  const double w1 = (1 - alpha) / alpha;
  const double end = std::acos(-(w1 + xi) / std::sqrt(2 * w1 * xi + xi * xi + 1));
  for (double angle = 0.0; angle < end; angle += 0.06) {
    const Vector3d p = 3.0 * at(angle, 4.0);
    const double d1 = p.norm(), z1 = xi * d1 + p.z();
    const double d2 = std::sqrt(p.x() * p.x() + p.y() * p.y() + z1 * z1);
    const Vector2d expected = p.head<2>() / (alpha * d2 + (1 - alpha) * z1);
    EXPECT_LT((image_of(lens, p) - expected).norm(), 100 * kSameFormula) << angle;
  }
  EXPECT_FALSE(has_image(lens, at(end + 1e-3, 0.0)));
  EXPECT_GT(expect_round_trips(lens, end - 1e-2), 500);
}

TEST(LensEucm, AgreesWithTheDoubleSphereWhereTheyCoincide) {
  // With xi = 0 the second sphere is the first: EUCM with beta = 1.
  const Lens sphere(LensKind::kDoubleSphere, {0.0, 0.62, kPi});
  const Lens lens(LensKind::kEucm, {0.62, 1.0, kPi});
  for (double angle = 0.0; angle < 2.5; angle += 0.03) {
    const Vector3d p = 2.0 * at(angle, 1.0);
    ASSERT_EQ(has_image(sphere, p), has_image(lens, p)) << angle;
    if (!has_image(lens, p)) continue;
    EXPECT_LT((image_of(lens, p) - image_of(sphere, p)).norm(), 100 * kSameFormula);
  }
  const Lens wide(LensKind::kEucm, {0.63, 1.04, kPi});
  const Vector3d p(0.3, -0.2, -0.1);
  const double d = std::sqrt(1.04 * (0.09 + 0.04) + 0.01);
  EXPECT_LT((image_of(wide, p) - p.head<2>() / (0.63 * d + 0.37 * p.z())).norm(), 100 * kSameFormula);
  EXPECT_GT(expect_round_trips(wide, 1.9), 500);
  EXPECT_TRUE(wide.unproject({2.0, 2.0}).isZero(0.0));
}

TEST(Lens, MaxAngleLimitsEveryLensThatHasIt) {
  for (std::size_t i = 0; i < lens_names().size(); ++i) {
    const LensKind kind = lens_from_string(lens_names()[i], "f", "model");
    const auto& names = lens_parameter_names(kind);
    if (names.empty()) continue;
    std::vector<double> parameters(names.size(), 0.0);
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (names[k] == "a1" || names[k] == "b1" || names[k] == "c" || names[k] == "beta") parameters[k] = 1.0;
      if (names[k] == "alpha") parameters[k] = 0.5;
    }
    ASSERT_EQ(names.back(), "max_angle_rad");
    parameters.back() = 0.5;
    const Lens lens(kind, parameters);
    EXPECT_TRUE(has_image(lens, at(0.499, 1.0))) << lens_names()[i];
    EXPECT_FALSE(has_image(lens, at(0.501, 1.0))) << lens_names()[i];
    EXPECT_GT(expect_round_trips(lens, 0.5), 100) << lens_names()[i];
  }
}

TEST(Lens, NothingIsMadeOfNan) {
  constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
  for (const Lens& lens : {Lens(),
                           Lens(LensKind::kOpencvPinhole, kFolded),
                           Lens(LensKind::kOpencvFisheye, {0, 0, 0, 0, kPi}),
                           Lens(LensKind::kFthetaInverse, {1, 0, 0, 0, 0, 1, 0, 0, kPi}),
                           Lens(LensKind::kEquirectangular, {}),
                           Lens(LensKind::kEucm, {0.5, 1.0, kPi})}) {
    EXPECT_FALSE(has_image(lens, {kNotANumber, 0.0, 1.0})) << to_string(lens.kind());
    EXPECT_FALSE(has_image(lens, {0.0, 0.0, kNotANumber})) << to_string(lens.kind());
    EXPECT_TRUE(lens.unproject({kNotANumber, 0.0}).isZero(0.0)) << to_string(lens.kind());
  }
}

TEST(Lens, RefusesWhatNoLensHas) {
  const auto refused = [](const char* part, LensKind kind, std::vector<double> parameters) {
    expect_error(ErrorKind::kInput, part, [&] { Lens(kind, parameters, "log.json"); });
  };
  refused("log.json: opencv_fisheye: found 3 parameters", LensKind::kOpencvFisheye, {0, 0, 0});
  refused("k2: found nan", LensKind::kOpencvFisheye, {0, std::nan(""), 0, 0, kPi});
  refused("max_angle_rad: found 4", LensKind::kOpencvFisheye, {0, 0, 0, 0, 4.0});
  refused("a1: found -1", LensKind::kFtheta, {-1, 0, 0, 0, 0, 1, 0, 0, kPi});
  refused("c, d, e", LensKind::kFthetaInverse, {1, 0, 0, 0, 0, 0, 0, 0, kPi});
  refused("xi: found -0.5", LensKind::kMei, {0, 0, 0, 0, -0.5, kPi});
  refused("xi: found 1.5", LensKind::kDoubleSphere, {1.5, 0.5, kPi});
  refused("alpha: found 1.1", LensKind::kEucm, {1.1, 1.0, kPi});
  expect_error(ErrorKind::kInput, "f: model: found \"fov\", allowed pinhole, opencv_pinhole", [] {
    (void)lens_from_string("fov", "f", "model");
  });
}

}  // namespace
}  // namespace simuli
