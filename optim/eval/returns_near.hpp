#pragma once
// How far away what a picture shows is, where the LiDAR says it.
#include <cstddef>
#include <optional>
#include <vector>

#include "host/core/scene/scene.hpp"
#include "io/log/log.hpp"

namespace simuli {

/// A recorded return where a picture shows it.
struct SeenReturn {
  std::size_t pixel = 0;  // row-major
  double range_m = 0.0;   // from the camera
};

/// Recorded returns in pictures taken at about the same time.
class ReturnsNear {
 public:
  static constexpr double kFarthest_s = 0.1;

  /// Both must outlive this.
  ReturnsNear(const Log& log, const Scene& scene) : log_(log), scene_(scene) {}
  /// Those of the sweep nearest in time to the picture of `frame`, taken by `camera`; a pixel has the nearest
  /// of those that fall on it. None when no sweep was taken within kFarthest_s. Error{kInput} when it can't
  /// be read.
  [[nodiscard]] std::vector<SeenReturn> in(const ImageFrame& frame, const Camera& camera);

 private:
  [[nodiscard]] std::optional<std::size_t> nearest_sweep(const ImageFrame& frame) const;
  void place(std::size_t index);

  const Log& log_;
  const Scene& scene_;
  std::optional<std::size_t> placed_;     // the sweep whose points these are
  std::vector<Eigen::Vector3d> p_scene_;  // m
};

}  // namespace simuli
