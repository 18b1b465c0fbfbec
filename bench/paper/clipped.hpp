#pragma once
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"
#include "host/core/sensors/lidar.hpp"

namespace simuli::bench {

/// Computes the light of single long particles that the extents of a projection cut off, relative to extent =
/// exact, in %:
/// table8_clipped/<lidar|pinhole|fisheye|pinhole_moving|lidar_moving>/<projection>/size_<5|10|20|30>_percent
/// with the standard error over 40 particles. Size: length over range, at 5 m. `lidar` is used at rest and at
/// 30 m/s; the cameras have 320 x 200 px and a field of view of 100 degrees (pinhole) or 180 degrees
/// (equidistant fisheye); the moving camera has a rolling shutter and moves by 1 m and 4 degrees per frame.
void add_clipped(const Device& device, const Lidar& lidar, const Note& note, std::vector<Row>& rows);

}  // namespace simuli::bench
