#include "host/device/render/options/lane_shape.hpp"

#include "host/device/runtime/tuning.hpp"

namespace simuli {

LaneShape lane_shape_of(const Device& device, Precision precision) {
  const DeviceTuning& tuned = tuning_of(device);
  if (precision == Precision::kFloat && tuned.lanes != 0)
    return {tuned.lanes, tuned.vectors, tuned.work_items};
  return usual_lane_shape(device, precision);
}

LaneShape usual_lane_shape(const Device& device, Precision precision) {
  if (!device.quirks().prefers_explicit_vectors) return {1, 4, 64};
  return precision == Precision::kFloat ? LaneShape{16, 16, 1} : LaneShape{8, 32, 1};
}

BuildOptions lane_options(const Device& device, Precision precision, int lanes) {
  BuildOptions options;
  return options.real(precision).define("V", lanes == 0 ? lane_shape_of(device, precision).lanes : lanes);
}

}  // namespace simuli
