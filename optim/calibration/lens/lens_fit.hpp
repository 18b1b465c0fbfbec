#pragma once
// Fits a camera model of one kind to another: parameters of `kind` that map the same directions to the same
// pixels. Converting F-theta between its reference directions inverts its polynomial.
#include <Eigen/Core>
#include <cstddef>

#include "host/core/sensors/camera.hpp"

namespace simuli::calibration {

struct LensFit {
  Camera camera;            // same name, size and shutter
  std::size_t samples = 0;  // rays that the fit used
  std::size_t checked = 0;  // other rays, used for the errors below
  double rms_px = 0.0;  // distance between the two models' pixels
  double largest_px = 0.0;
  Eigen::Vector2d largest_at = Eigen::Vector2d::Zero();  // pixel of the source
  double uncovered_share = 0.0;  // share of the source's pixels with a ray without image in the fitted model
};

/// Optimises focal lengths, centre and lens parameters with Ceres, on rays of a pixel grid. Uses rational terms
/// of opencv_pinhole where polynomials do not reach a hundredth of a pixel; thin-prism terms stay 0.
/// max_angle_rad becomes the widest ray used. Throws Error{kUsage} for `equirectangular`, which has no
/// parameters, Error{kNumeric} when no ray is usable or no solution is found.
[[nodiscard]] LensFit fit_lens(const Camera& source, LensKind kind);

/// Pixel of `direction` and its derivatives by the fitted parameters, for tests: [2 x (4 + lens parameters
/// without max_angle_rad)], order fx, fy, cx, cy, then lens_parameter_names(kind).
[[nodiscard]] Eigen::Matrix<double, 2, Eigen::Dynamic> pixel_derivatives(const Camera& camera,
                                                                         const Eigen::Vector3d& direction);

}  // namespace simuli::calibration
