#pragma once
#include <Eigen/Core>
#include <string>

namespace simuli {

/// In which order the pixels of one frame are exposed.
enum class ShutterKind { kGlobal, kTopToBottom, kBottomToTop, kLeftToRight, kRightToLeft };

/// A camera model. Frame: OpenCV (x right, y down, z forward); pixel (0,0) has its centre at
/// (0.5, 0.5), so the picture covers [0, width] x [0, height].
struct Camera {
  std::string name;
  int width = 0;   // pixels
  int height = 0;  // pixels
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  // pixels
  ShutterKind shutter = ShutterKind::kGlobal;

  /// Unit ray direction in the camera frame through `pixel`.
  [[nodiscard]] Eigen::Vector3d unproject(const Eigen::Vector2d& pixel) const;
  /// Pixel of a point in the camera frame; false when it lies behind the camera.
  [[nodiscard]] bool project(const Eigen::Vector3d& p_camera, Eigen::Vector2d& pixel) const;
  /// Share of the read-out at which `pixel` is exposed, 0 at the start of the frame, 1 at its end.
  [[nodiscard]] double exposure_fraction(const Eigen::Vector2d& pixel) const;
  /// The same camera with a picture of new_width x new_height (continuous coordinates are scaled).
  [[nodiscard]] Camera resized(int new_width, int new_height) const;
};

/// Shutter names as they stand in files: "global", "top_to_bottom", ...
[[nodiscard]] const char* to_string(ShutterKind kind);
/// Throws Error{kInput} naming `file` and `field` for an unknown name.
[[nodiscard]] ShutterKind shutter_from_string(const std::string& name,
                                              const std::string& file,
                                              const std::string& field);

/// Throws Error{kInput} naming `file` and the field for a size, focal length or centre that no camera
/// has (non-finite, not positive, more than 65 536 pixels a side).
void validate(const Camera& camera, const std::string& file);

}  // namespace simuli
