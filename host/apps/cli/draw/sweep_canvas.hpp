#pragma once
// A sweep as a picture: where each of its rays stands.
#include <array>
#include <cstddef>
#include <vector>

#include "host/core/base/image.hpp"
#include "host/core/sensors/lidar_model.hpp"

namespace simuli::cli {

/// kNoRay all over, until rays are drawn. Of a LiDAR with rows: beams from top to bottom, each kBeam_px tall,
/// from left to right as seen from the sensor, where a column is an azimuth. A beam whose rays fire ahead of
/// the others' or behind them is moved by so many columns, round the turn or, of a part of a turn, into a
/// wider picture; where that is no whole number, rays are drawn twice as large and it is right to a pixel,
/// unless the picture got wider than kWidest_px. Beams are found where they were fired, whatever the model
/// says. Rays of a list: where they point to, as squares of kListRay_px, equally many pixels per rad both
/// ways.
class SweepCanvas {
 public:
  static constexpr int kBeam_px = 4;
  static constexpr int kListRay_px = 2;
  static constexpr int kWidest_px = 4096;
  static constexpr std::array<float, 3> kNoRay{0.32F, 0.32F, 0.34F};

  SweepCanvas(const LidarModel& lidar, const LidarRays& rays);
  /// Over what was drawn before.
  void draw(std::size_t ray, const std::array<float, 3>& colour);
  [[nodiscard]] Image finish() && { return std::move(image_); }

 private:
  struct Place {
    int x, y;  // of the top left corner
  };
  void place_rows(const Lidar& lidar, const LidarRays& rays);
  void place_list(const LidarRays& rays);

  std::vector<Place> places_;  // [rays]
  int ray_width_ = kListRay_px, ray_height_ = kListRay_px;
  Image image_;
};

}  // namespace simuli::cli
