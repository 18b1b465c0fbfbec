#pragma once
// Picture of a LiDAR sweep.
#include <array>
#include <cstddef>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/sensors/lidar_model.hpp"

namespace simuli::cli {

/// A picture filled with kNoRay, on which rays are drawn. A LiDAR with beams: beams from top to bottom, each
/// kBeam_px high, and columns of equal azimuth from left to right as seen from the sensor. A beam with an
/// azimuth offset is moved by whole columns; a full revolution wraps around, a partial one widens the
/// picture. If offsets are not whole columns, rays are drawn twice as large, unless the picture exceeds
/// kWidest_px. Offsets follow from the azimuths of `rays`, not from the model. A ray list: rays at their
/// azimuth and elevation as squares of kListRay_px, with the same scale in both directions.
class SweepCanvas {
 public:
  static constexpr int kBeam_px = 4;
  static constexpr int kListRay_px = 2;
  static constexpr int kWidest_px = 4096;
  static constexpr std::array<float, 3> kNoRay{0.32F, 0.32F, 0.34F};

  SweepCanvas(const LidarModel& lidar, const LidarRays& rays);
  /// Draws a ray over previous ones.
  void draw(std::size_t ray, const std::array<float, 3>& colour);
  [[nodiscard]] Image finish() && { return std::move(image_); }

 private:
  struct Place {
    int x, y;  // top left corner
  };
  void place_rows(const Lidar& lidar, const LidarRays& rays);
  void place_list(const LidarRays& rays);

  std::vector<Place> places_;  // [rays]
  int ray_width_ = kListRay_px, ray_height_ = kListRay_px;
  Image image_;
};

}  // namespace simuli::cli
