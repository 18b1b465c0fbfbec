#pragma once
// Losses of what was rendered: their sums and their weights.
#include "host/core/scene/ray_drop.hpp"

namespace simuli {

/// Sums of a picture's loss, over all known pixels and channels.
struct ImageLoss {
  double absolute = 0.0;
  double squared = 0.0;
  double dissimilarity = 0.0;  // 1 - SSIM; 0 where its scale is
};

/// Weights of a picture's losses over the number of values (3 x known pixels).
struct ImageLossScale {
  double absolute = 0.0;
  double squared = 0.0;
  double dissimilarity = 0.0;
  // Of the pixels that the truth's fourth channel marks (1: sky): the sum of their particles' weights, each times
  // 1 - distance / sky_from_m, where it is above 0.
  double sky = 0.0;
  double sky_from_m = 1.0;
};

/// Sums of a sweep's losses: |d^ - d| sqrt(10 m / max(d, 1 m)) (m) and |intensity error| over returned rays, cross
/// entropy and wrong drop decisions over all rays. drop: dL/d(parameters of the drop function), scaled.
struct LidarLoss {
  double distance_m = 0.0;
  double intensity = 0.0;
  double entropy = 0.0;
  double wrong = 0.0;
  RayDrop::Parameters drop{};
};

/// Weights of a sweep's losses over the number of rays that each is the mean of.
struct LidarLossScale {
  double distance = 0.0;
  double intensity = 0.0;
  double entropy = 0.0;           // in what particles get
  double function_entropy = 0.0;  // in what the drop function gets
};

}  // namespace simuli
