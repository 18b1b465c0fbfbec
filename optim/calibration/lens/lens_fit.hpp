#pragma once
// One camera model in terms of another: the parameters of `kind` that send the same directions to the same
// pixels. F-theta in one reference direction to the other is the inversion of its polynomial.
#include <Eigen/Core>
#include <cstddef>

#include "host/core/sensors/camera.hpp"

namespace simuli::calibration {

struct LensFit {
  Camera camera;            // same name, size and shutter
  std::size_t samples = 0;  // rays that the fit used
  std::size_t checked = 0;  // other rays, on which the errors below were measured
  double rms_px = 0.0;      // distance between the two models' pixels
  double largest_px = 0.0;
  Eigen::Vector2d largest_at = Eigen::Vector2d::Zero();  // pixel of the source
  double uncovered_share = 0.0;  // of the source's pixels with a ray, that the fitted model has no image for
};

/// Ceres over focal lengths, centre and the lens's parameters, on rays of a grid of pixels. Rational terms
/// of opencv_pinhole are used where polynomials do not reach a hundredth of a pixel; thin-prism
/// terms stay off. max_angle_rad becomes the widest ray used. Throws Error{kUsage} for
/// `equirectangular`, which has nothing to fit, Error{kNumeric} when no ray can be used or nothing is found.
[[nodiscard]] LensFit fit_lens(const Camera& source, LensKind kind);

/// Pixel of `direction` and its derivatives by the fitted parameters, for tests: [2 x (4 + lens parameters
/// without max_angle_rad)], order fx, fy, cx, cy, then lens_parameter_names(kind).
[[nodiscard]] Eigen::Matrix<double, 2, Eigen::Dynamic> pixel_derivatives(const Camera& camera,
                                                                         const Eigen::Vector3d& direction);

}  // namespace simuli::calibration
