#pragma once
// Distances of a picture's pixels from LiDAR returns.
#include <cstddef>
#include <optional>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// A recorded return in a picture.
struct SeenReturn {
  std::size_t pixel = 0;  // row-major
  double range_m = 0.0;  // from the camera
};

/// Recorded returns in pictures taken at about the same time.
class ReturnsNear {
 public:
  static constexpr double kFarthest_s = 0.1;

  /// Both must outlive this object.
  ReturnsNear(const Log& log, const Scene& scene) : log_(log), scene_(scene) {}
  /// Projects the returns of the sweep nearest in time to the picture of `frame`, taken by `camera`; a pixel
  /// keeps its nearest return. Empty when no sweep is within kFarthest_s. Throws Error{kInput} when the file
  /// cannot be read.
  [[nodiscard]] std::vector<SeenReturn> in(const ImageFrame& frame, const Camera& camera);

 private:
  [[nodiscard]] std::optional<std::size_t> nearest_sweep(const ImageFrame& frame) const;
  void place(std::size_t index);

  const Log& log_;
  const Scene& scene_;
  std::optional<std::size_t> placed_;  // the sweep of these points
  std::vector<Eigen::Vector3d> p_scene_;  // m
};

}  // namespace simuli
