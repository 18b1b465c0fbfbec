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
  bool actors = false;  // adds a column "actor" (uint16): Frame::actors()
  std::vector<std::uint16_t> classes = {};  // [actors], adds a column "class" of the actor, 0 without one
  std::vector<float> support =
      {};  // [rays], adds a column "support" (SupportOnDevice::of()); empty: none
};

/// Returns a row per returned ray, in the sensor's order: x y z (m), intensity [0, 1], range (m, from the ray's
/// own origin), drop (ray-drop probability), ring (row of the beam, 0 at the top, uint16; only LiDARs with
/// rows) and time (s since the frame's start). Throws Error{kUsage} for a camera.
[[nodiscard]] PointCloud point_cloud(const Frame& frame, const CloudOptions& options = {});

/// Returns the type that represents world coordinates of up to `farthest_m` to a millimetre.
[[nodiscard]] ColumnType coordinates_to_a_millimetre(double farthest_m);

}  // namespace simuli
