#include "optim/calibration/lens/lens_fit.hpp"

#include <gtest/gtest.h>
#include <random>

#include "host/core/base/error.hpp"

namespace simuli::calibration {
namespace {

const std::vector<LensKind> kFitted{LensKind::kPinhole,
                                    LensKind::kOpencvPinhole,
                                    LensKind::kOpencvFisheye,
                                    LensKind::kFtheta,
                                    LensKind::kFthetaInverse,
                                    LensKind::kMei,
                                    LensKind::kDoubleSphere,
                                    LensKind::kEucm};

Camera some_camera(LensKind kind) {
  Camera camera{"some", 640, 480, 300.0, 310.0, 322.0, 239.0, ShutterKind::kGlobal, {}};
  switch (kind) {
    case LensKind::kOpencvPinhole:
      camera.lens =
          Lens(kind, {-0.2, 0.05, 1e-3, -5e-4, -0.01, 0.02, 0.01, 0.002, 1e-3, 2e-4, -1e-3, 1e-4, 1.2});
      break;
    case LensKind::kOpencvFisheye:
      camera.lens = Lens(kind, {0.02, -0.01, 0.003, -5e-4, 1.5});
      break;
    case LensKind::kFtheta:
      camera.lens = Lens(kind, {1.0, 0.01, -0.05, 0.01, -0.002, 1.001, 0.002, -0.001, 1.5});
      break;
    case LensKind::kFthetaInverse:
      camera.lens = Lens(kind, {1.0, -0.01, 0.05, -0.01, 0.002, 1.001, 0.002, -0.001, 1.2});
      break;
    case LensKind::kMei:
      camera.lens = Lens(kind, {-0.1, 0.02, 1e-3, -5e-4, 0.9, 1.5});
      break;
    case LensKind::kDoubleSphere:
      camera.lens = Lens(kind, {-0.2, 0.58, 1.6});
      break;
    case LensKind::kEucm:
      camera.lens = Lens(kind, {0.6, 1.1, 1.5});
      break;
    default:
      break;
  }
  return camera;
}

/// Returns the camera with parameter `index` (fx, fy, cx, cy, then the lens's) changed by `step`.
Camera changed(const Camera& camera, std::size_t index, double step) {
  Camera out = camera;
  const std::array<double*, 4> focal{&out.fx, &out.fy, &out.cx, &out.cy};
  if (index < focal.size()) {
    *focal[index] += step;
    return out;
  }
  std::vector<double> lens = camera.lens.parameters();
  lens[index - focal.size()] += step;
  out.lens = Lens(camera.lens.kind(), lens);
  return out;
}

TEST(LensFit, DerivativesAreThoseOfTheLensItself) {
  for (const LensKind kind : kFitted) {
    const Camera camera = some_camera(kind);
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.3, -0.2, 1.0), Eigen::Vector3d(-0.5, 0.4, 1.0)}) {
      const Eigen::Vector3d direction = p.normalized();
      const auto derivatives = pixel_derivatives(camera, direction);
      for (Eigen::Index k = 0; k < derivatives.cols(); ++k) {
        constexpr double kStep = 1e-6;
        Eigen::Vector2d above;
        Eigen::Vector2d below;
        ASSERT_TRUE(changed(camera, static_cast<std::size_t>(k), kStep).project(direction, above));
        ASSERT_TRUE(changed(camera, static_cast<std::size_t>(k), -kStep).project(direction, below));
        const Eigen::Vector2d slope = (above - below) / (2.0 * kStep);
        // Differences of pixels near 300 at a step of 1e-6 have an absolute error of 1e-7.
        EXPECT_LT((derivatives.col(k) - slope).norm(), 1e-5 * (1.0 + slope.norm()))
            << to_string(kind) << " parameter " << k;
      }
    }
  }
}

TEST(LensFit, EveryLensIsFoundAgainByItsOwnKind) {
  for (const LensKind kind : kFitted) {
    Camera camera = some_camera(kind);
    // Parameters that the fit does not change.
    if (kind == LensKind::kOpencvPinhole) {
      camera.lens = Lens(kind, {-0.2, 0.05, 1e-3, -5e-4, -0.01, 0, 0, 0, 0, 0, 0, 0, 1.0});
    } else if (kind == LensKind::kFtheta || kind == LensKind::kFthetaInverse) {
      std::vector<double> lens = camera.lens.parameters();
      lens[5] = 1.0;  // is determined by the focal lengths
      camera.lens = Lens(kind, lens);
    }
    const LensFit fit = fit_lens(camera, kind);
    EXPECT_GT(fit.checked, 1000U) << to_string(kind);
    // Two parameters of a mirror are nearly equivalent to the focal length: the fit ends in a flat valley.
    const bool is_mirror =
        kind == LensKind::kMei || kind == LensKind::kDoubleSphere || kind == LensKind::kEucm;
    EXPECT_LT(fit.largest_px, is_mirror ? 0.3 : 1e-4) << to_string(kind);
  }
}

TEST(LensFit, InvertsThePolynomialOfAnFthetaLens) {
  Camera camera = some_camera(LensKind::kFtheta);
  camera.lens = Lens(LensKind::kFtheta, {1.0, 0.0, -0.04, 0.0, 0.004, 1.0, 0.0, 0.0, 1.3});
  const LensFit inverse = fit_lens(camera, LensKind::kFthetaInverse);
  EXPECT_LT(inverse.largest_px, 0.05);
  EXPECT_LT(inverse.rms_px, 0.01);
  const LensFit again = fit_lens(inverse.camera, LensKind::kFtheta);
  EXPECT_LT(again.largest_px, 0.05);
}

TEST(LensFit, SaysHowWellAPoorModelDoes) {
  // A pinhole has no distortion: the residual is the fisheye's distortion, measured on other rays.
  const LensFit fit = fit_lens(some_camera(LensKind::kOpencvFisheye), LensKind::kPinhole);
  EXPECT_GT(fit.rms_px, 1.0);
  EXPECT_GE(fit.largest_px, fit.rms_px);
  double largest = 0.0;
  const Camera source = some_camera(LensKind::kOpencvFisheye);
  Eigen::Vector2d pixel;
  ASSERT_TRUE(fit.camera.project(source.unproject(fit.largest_at), pixel));
  largest = (pixel - fit.largest_at).norm();
  EXPECT_NEAR(largest, fit.largest_px, 1e-9);
}

TEST(LensFit, RealLensesGoIntoOthers) {
  // An F-theta lens of 120 degrees as a Kannala-Brandt polynomial: both are nearly odd polynomials of the
  // angle.
  for (const std::string& name : builtin_camera_names()) {
    const Camera camera = builtin_camera(name);
    if (camera.lens.kind() != LensKind::kFtheta && camera.lens.kind() != LensKind::kFthetaInverse) continue;
    const LensFit fit = fit_lens(camera, LensKind::kOpencvFisheye);
    EXPECT_LT(fit.rms_px, 2.0) << name;
    EXPECT_LT(fit.uncovered_share, 0.01) << name;
  }
}

TEST(LensFit, RefusesWhatHasNothingToFit) {
  try {
    (void)fit_lens(some_camera(LensKind::kPinhole), LensKind::kEquirectangular);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_NE(std::string(error.what()).find("equirectangular"), std::string::npos);
  }
}

}  // namespace
}  // namespace simuli::calibration
