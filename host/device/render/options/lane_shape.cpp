#include "host/device/render/options/lane_shape.hpp"

namespace simuli {

LaneShape lane_shape_of(const Device& device, Precision precision) {
  if (!device.quirks().prefers_explicit_vectors)
    return device.info().max_work_group_size < 256 ? LaneShape{1, 4, 64} : LaneShape{1, 1, 256};
  return precision == Precision::kFloat ? LaneShape{16, 16, 1} : LaneShape{8, 32, 1};
}

BuildOptions lane_options(const Device& device, Precision precision, int lanes) {
  BuildOptions options;
  return options.real(precision).define("V", lanes == 0 ? lane_shape_of(device, precision).lanes : lanes);
}

}  // namespace simuli
