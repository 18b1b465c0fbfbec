#pragma once
// A LiDAR's frame as a point cloud.
#include <cstdint>
#include <vector>

#include "host/core/base/point_cloud.hpp"
#include "host/device/render/scene/frame.hpp"

namespace simuli {

struct CloudOptions {
  PointFrame frame = PointFrame::kWorld;
  ColumnType coordinates = ColumnType::kFloat;  // of x, y and z
  bool actors = false;                          // with a column "actor" (uint16): Frame::actors()
  std::vector<std::uint16_t> classes = {};      // [actors], then also a column "class": theirs, 0 of no actor
  std::vector<float> support =
      {};  // [rays], with a column "support" of them: SupportOnDevice::of(); empty: without
};

/// A row per ray that returned, in the sensor's order: x y z (m), intensity [0, 1], range (m, from the ray's
/// own origin), drop (the probability that the ray does not return), ring (the beam's row, 0 at the top,
/// uint16; of LiDARs with rows alone) and time (s since the frame's start). Error{kUsage} of a camera.
[[nodiscard]] PointCloud point_cloud(const Frame& frame, const CloudOptions& options = {});

/// The type that holds world coordinates of up to `farthest_m` to a millimetre.
[[nodiscard]] ColumnType coordinates_to_a_millimetre(double farthest_m);

}  // namespace simuli
