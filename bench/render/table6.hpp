#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/render/lidar_frames.hpp"

namespace simuli::bench {

/// Table 6 of the paper: how long a frame takes by elevation tiles and rays per tile.
///   table6/<sensor>_<n>k/<elevation tiles>x<rays>[_chosen]     ms per frame; chosen: the fastest of the grid
///   table6/<sensor>_<n>k/automatic                             ms, of what nothing asked for gives
///   table6/<sensor>_<n>k/slowest_over_chosen                   ratio
[[nodiscard]] std::vector<Row> run_table6(const std::string& device_request,
                                          std::int64_t particles,
                                          const Progress& note);

/// Millions of rays per second for 64 x 2650, 128 x 3600 and 16 x 1800 rays and 50 k, 200 k and 1 M
/// particles: in tiles of 8 beams without culling, and as rendered by default, frames of both in turns.
///   lidar_rate/<sensor>_<n>k/<before|after>, .../ratio
[[nodiscard]] std::vector<Row> run_lidar_rates(const std::string& device_request, const Progress& note);

}  // namespace simuli::bench
