#pragma once
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"
#include "host/core/sensors/lidar.hpp"

namespace simuli::bench {

/// What the box of a projection cuts off a single long particle: the light that its rays gather with
/// extent = exact, which loses nothing, less what they gather with that projection, in % of the former.
///   table8_clipped/<lidar|pinhole|fisheye|pinhole_moving|lidar_moving>/<projection>/size_<5|10|20|30>_percent
/// give or take the standard error over 40 particles. Size: length over range, at 5 m. `lidar` is used at
/// rest and at 30 m/s; the cameras have 320 x 200 px, 100 degrees (pinhole) and 180 degrees across
/// (equidistant fisheye), the moving one a rolling shutter and 1 m and 4 degrees in its frame.
void add_clipped(const Device& device, const Lidar& lidar, const Note& note, std::vector<Row>& rows);

}  // namespace simuli::bench
