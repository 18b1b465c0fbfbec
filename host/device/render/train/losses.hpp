#pragma once
// Sums and weights of losses.
#include "host/core/scene/ray_drop.hpp"

namespace simuli {

/// Sums of a picture's losses over all known pixels and channels.
struct ImageLoss {
  double absolute = 0.0;
  double squared = 0.0;
  double dissimilarity = 0.0;  // 1 - SSIM; 0 when its scale is
};

/// Weights of a picture's losses, divided by the number of values (3 x known pixels).
struct ImageLossScale {
  double absolute = 0.0;
  double squared = 0.0;
  double dissimilarity = 0.0;
  // Weight of the sky loss: over the pixels that the truth's fourth channel marks (1: sky), the sum of the
  // particles' weights times 1 - distance / sky_from_m, where positive.
  double sky = 0.0;
  double sky_from_m = 1.0;
};

/// Sums of a sweep's losses: |d^ - d| sqrt(10 m / max(d, 1 m)) (m) and |intensity error| over returned rays,
/// cross entropy and wrong ray-drop decisions over all rays. drop: dL/d(parameters of the ray-drop function),
/// scaled.
struct LidarLoss {
  double distance_m = 0.0;
  double intensity = 0.0;
  double entropy = 0.0;
  double wrong = 0.0;
  RayDrop::Parameters drop{};
};

/// Weights of a sweep's losses, each divided by its number of rays.
struct LidarLossScale {
  double distance = 0.0;
  double intensity = 0.0;
  double entropy = 0.0;  // for the gradient of particles
  double function_entropy = 0.0;  // for the gradient of the ray-drop function
};

}  // namespace simuli
