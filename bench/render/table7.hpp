#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/render/lidar_frames.hpp"

namespace simuli::bench {

/// Table 7 of the paper: stages with and without ray-based culling (on: a mask row per beam, two mask columns
/// per column if only some rays are requested), frames of both in turns, for a full sweep, 1 of 16 evenly
/// spread rays, every 16th column, every 16th beam, an eighth of the sweep, and a sensor with a field of view
/// of 60 degrees. If each cell contains a ray, culling is skipped and both variants are equal.
///   table7/<case>_<n>k/<project|sort|bin|blend|frame>_<off|on>  ms
///   table7/<case>_<n>k/<...>_saved                              % of off
///   table7/<case>_<n>k/<particles|pairs>_removed                % of the visible ones
///   table7/<case>_<n>k/pairs_in_empty_tiles                     % of the remaining pairs: possible further
/// saving of a test per tile
///   table7/full_sweep_<n>k/particles_<beside|between>_the_beams % removed in projection by the beam
/// elevations, without a mask
[[nodiscard]] std::vector<Row> run_table7(const std::string& device_request,
                                          std::int64_t particles,
                                          const Progress& note);

}  // namespace simuli::bench
