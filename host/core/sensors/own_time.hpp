#pragma once
// Projection of moving points at their own shutter time.
#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>

#include "host/core/sensors/camera.hpp"

namespace simuli {

struct OwnTimeImage {
  Eigen::Vector2d pixel;
  double share = 0.5;  // of the frame, time of exposure
};

/// Accuracy of the iteration.
struct OwnTimeAccuracy {
  int most = 12;             // iterations after the first one at mid-frame
  double settled_px = 1e-4;  // converged below this change
  // Share of the picture's sides; a point farther outside has no image.
  double margin = std::numeric_limits<double>::infinity();
};

inline bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel, double margin = 0.0) {
  return pixel.x() >= -margin * camera.width && pixel.x() < (1.0 + margin) * camera.width &&
         pixel.y() >= -margin * camera.height && pixel.y() < (1.0 + margin) * camera.height;
}

/// Returns the image of a point at p_camera(share) m, possibly outside of the picture: the fixed point of
/// METHOD section 3, starting at mid-frame. No value without an image. The last call of p_camera() has the
/// returned share.
template <class PCamera>
[[nodiscard]] std::optional<OwnTimeImage> image_at_own_time(const Camera& camera,
                                                            const PCamera& p_camera,
                                                            const OwnTimeAccuracy& looks = {}) {
  OwnTimeImage image;
  if (!camera.project(p_camera(image.share), image.pixel)) return std::nullopt;
  if (camera.shutter == ShutterKind::kGlobal) return image;
  if (!is_inside(camera, image.pixel, looks.margin)) return std::nullopt;
  for (int look = 0; look < looks.most; ++look) {
    const Eigen::Vector2d before = image.pixel;
    image.share = std::clamp(camera.exposure_fraction(before), 0.0, 1.0);
    if (!camera.project(p_camera(image.share), image.pixel)) return std::nullopt;
    if ((image.pixel - before).squaredNorm() < looks.settled_px * looks.settled_px) break;
  }
  return image;
}

}  // namespace simuli
