#pragma once
// Points that a camera sees at the time at which its shutter comes to them.
#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>

#include "host/core/sensors/camera.hpp"

namespace simuli {

struct OwnTimeImage {
  Eigen::Vector2d pixel;
  double share = 0.5;  // of the frame, when it is seen
};

/// How closely it is asked for.
struct OwnTimeObservations {
  int most = 12;                                            // after the one at the middle of the frame
  double settled_px = 1e-4;                                 // what moves it by less is the last
  double margin = std::numeric_limits<double>::infinity();  // of the picture's sides: farther out it has none
};

inline bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel, double margin = 0.0) {
  return pixel.x() >= -margin * camera.width && pixel.x() < (1.0 + margin) * camera.width &&
         pixel.y() >= -margin * camera.height && pixel.y() < (1.0 + margin) * camera.height;
}

/// Where the camera sees a point that is at p_camera(share) m then, which may be outside of the picture: the
/// fixed point of METHOD section 3, from the middle of the frame on. None: it has no image. p_camera() was
/// asked last for the share that is returned.
template <class PCamera>
[[nodiscard]] std::optional<OwnTimeImage> image_at_own_time(const Camera& camera,
                                                            const PCamera& p_camera,
                                                            const OwnTimeObservations& looks = {}) {
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
