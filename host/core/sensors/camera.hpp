#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/core/sensors/lens.hpp"

namespace simuli {

/// Exposure order of a frame's pixels.
enum class ShutterKind { kGlobal, kTopToBottom, kBottomToTop, kLeftToRight, kRightToLeft };

/// A camera model: pixel = (fx u + cx, fy v + cy) of the lens's image (u, v). Frame: OpenCV (x right, y down, z
/// forward); pixel (0,0) has its centre at (0.5, 0.5), so the picture covers [0, width] x [0, height]. OpenCV
/// and Kalibr count from the centre of the first pixel: add 0.5 to their cx and cy.
struct Camera {
  std::string name;
  int width = 0;                                  // pixels
  int height = 0;                                 // pixels
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  // pixels
  ShutterKind shutter = ShutterKind::kGlobal;
  Lens lens = {};

  /// Unit ray direction in the camera frame through `pixel`; zero where the lens has none.
  [[nodiscard]] Eigen::Vector3d unproject(const Eigen::Vector2d& pixel) const;
  /// Projects a point in the camera frame; false outside the lens's domain (behind a pinhole, past the fold of
  /// a distortion, nearer than 1 cm). The pixel may be outside the picture.
  [[nodiscard]] bool project(const Eigen::Vector3d& p_camera, Eigen::Vector2d& pixel) const;
  /// Pixels per rad at the optical axis, mean of both axes.
  [[nodiscard]] double focal_px() const;
  /// Share of the read-out at which `pixel` is exposed, 0 at the start of the frame, 1 at its end.
  [[nodiscard]] double exposure_fraction(const Eigen::Vector2d& pixel) const;
  /// Returns the camera with a picture of new_width x new_height (continuous coordinates are scaled).
  [[nodiscard]] Camera resized(int new_width, int new_height) const;
  bool operator==(const Camera&) const = default;
};

/// Sets fx, fy (the slope at the axis) and the lens of `camera` from a vendor's F-theta polynomial: of the
/// radius in pixels (kFtheta) or of the angle by pixels (kFthetaInverse), coefficients of degree 1 to 5.
void set_ftheta(Camera& camera,
                LensKind kind,
                const std::array<double, 5>& polynomial,
                const std::array<double, 3>& linear_cde,
                double max_angle_rad);

/// Field of view in rad along the row and the column through the principal point, over pixels with a ray,
/// including full turns of a fisheye.
struct ViewAngle {
  double horizontal_rad = 0.0, vertical_rad = 0.0;
};
[[nodiscard]] ViewAngle view_angle(const Camera& camera);

/// Returns the number of pixels without a ray through the lens.
[[nodiscard]] std::size_t pixels_without_ray(const Camera& camera);

/// Returns the file name of a shutter: "global", "top_to_bottom", ...
[[nodiscard]] const char* to_string(ShutterKind kind);
/// Throws Error{kInput} with `file` and `field` for an unknown name.
[[nodiscard]] ShutterKind shutter_from_string(const std::string& name,
                                              const std::string& file,
                                              const std::string& field);

/// Throws Error{kInput} with `file` and the field for an invalid size, focal length or centre (non-finite, not
/// positive, more than 65 536 pixels a side); an equirectangular picture must span one turn (fx = width / 2 pi)
/// and not be exposed along it.
void validate(const Camera& camera, const std::string& file);

/// A built-in camera by name; throws Error{kUsage} listing the known names.
[[nodiscard]] Camera builtin_camera(const std::string& name);
[[nodiscard]] std::vector<std::string> builtin_camera_names();
/// Returns the source and licence of its numbers.
[[nodiscard]] std::string builtin_camera_source(const std::string& name);

}  // namespace simuli
