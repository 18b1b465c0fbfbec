#pragma once
// Points that a camera sees at the time at which its shutter comes to them.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "host/core/sensors/camera.hpp"

namespace simuli {

struct OwnTimeImage {
  Eigen::Vector2d pixel;
  double share = 0.5;  // of the frame, when it is seen
};

/// Where the camera sees a point that is at p_camera(share) m then, which may be outside of the picture: the
/// fixed point of METHOD section 3, from the middle of the frame on. None: it has no image.
template <class PCamera>
[[nodiscard]] std::optional<OwnTimeImage> image_at_own_time(const Camera& camera, const PCamera& p_camera) {
  constexpr int kMostLooks = 12;
  constexpr double kSettled = 1e-7;  // of the frame
  OwnTimeImage image;
  for (int look = 0; look < kMostLooks; ++look) {
    if (!camera.project(p_camera(image.share), image.pixel)) return std::nullopt;
    const double seen = std::clamp(camera.exposure_fraction(image.pixel), 0.0, 1.0);
    const bool is_settled = std::abs(seen - image.share) <= kSettled;
    image.share = seen;
    if (is_settled) break;
  }
  return image;
}

}  // namespace simuli
