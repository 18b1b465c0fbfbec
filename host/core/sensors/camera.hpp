#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/core/sensors/lens.hpp"

namespace simuli {

/// In which order the pixels of one frame are exposed.
enum class ShutterKind { kGlobal, kTopToBottom, kBottomToTop, kLeftToRight, kRightToLeft };

/// A camera model: pixel = (fx u + cx, fy v + cy) of the lens's image (u, v). Frame: OpenCV (x right, y down,
/// z forward); pixel (0,0) has its centre at (0.5, 0.5), so the picture covers [0, width] x [0, height].
/// OpenCV and Kalibr count from the centre of the first pixel: add 0.5 to their cx and cy.
struct Camera {
  std::string name;
  int width = 0;                                  // pixels
  int height = 0;                                 // pixels
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  // pixels
  ShutterKind shutter = ShutterKind::kGlobal;
  Lens lens = {};

  /// Unit ray direction in the camera frame through `pixel`; zero where the lens has none.
  [[nodiscard]] Eigen::Vector3d unproject(const Eigen::Vector2d& pixel) const;
  /// Pixel of a point in the camera frame; false when it lies outside the lens's domain (behind a pinhole,
  /// past the fold of a distortion, nearer than 1 cm). It may lie outside the picture.
  [[nodiscard]] bool project(const Eigen::Vector3d& p_camera, Eigen::Vector2d& pixel) const;
  /// Pixels per rad at the optical axis, mean of both axes.
  [[nodiscard]] double focal_px() const;
  /// Share of the read-out at which `pixel` is exposed, 0 at the start of the frame, 1 at its end.
  [[nodiscard]] double exposure_fraction(const Eigen::Vector2d& pixel) const;
  /// The same camera with a picture of new_width x new_height (continuous coordinates are scaled).
  [[nodiscard]] Camera resized(int new_width, int new_height) const;
  bool operator==(const Camera&) const = default;
};

/// A polynomial of the radius in pixels (kFtheta) or of the angle over pixels (kFthetaInverse), coefficients
/// of degree 1 to 5, as vendors give it: sets fx, fy (the slope at the axis) and the lens of `camera`.
void set_ftheta(Camera& camera,
                LensKind kind,
                const std::array<double, 5>& polynomial,
                const std::array<double, 3>& linear_cde,
                double max_angle_rad);

/// What the picture spans, rad, along the row and the column through the principal point: of pixels that have
/// a ray, whole turns of a fisheye included.
struct ViewAngle {
  double horizontal_rad = 0.0, vertical_rad = 0.0;
};
[[nodiscard]] ViewAngle view_angle(const Camera& camera);

/// Number of pixels through whose centre the lens has no ray.
[[nodiscard]] std::size_t pixels_without_ray(const Camera& camera);

/// Shutter names as they stand in files: "global", "top_to_bottom", ...
[[nodiscard]] const char* to_string(ShutterKind kind);
/// Throws Error{kInput} naming `file` and `field` for an unknown name.
[[nodiscard]] ShutterKind shutter_from_string(const std::string& name,
                                              const std::string& file,
                                              const std::string& field);

/// Throws Error{kInput} naming `file` and the field for a size, focal length or centre that no camera
/// has (non-finite, not positive, more than 65 536 pixels a side); an equirectangular picture must be
/// one turn wide (fx = width / 2 pi) and not be exposed along the turn.
void validate(const Camera& camera, const std::string& file);

/// A built-in camera by name; throws Error{kUsage} listing the known names.
[[nodiscard]] Camera builtin_camera(const std::string& name);
[[nodiscard]] std::vector<std::string> builtin_camera_names();
/// Where its numbers come from, and under which licence.
[[nodiscard]] std::string builtin_camera_source(const std::string& name);

}  // namespace simuli
