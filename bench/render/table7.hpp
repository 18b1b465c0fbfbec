#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/render/lidar_frames.hpp"

namespace simuli::bench {

/// Table 7 of the paper: stages without ray-based culling and with it (on: a row per beam, two columns per
/// firing where some of the rays are requested), frames of both in turns, for a full sweep, for 1 ray in 16
/// of it spread evenly, for every 16th firing, for every 16th beam, for an eighth of the sweep, and for a
/// sensor that sweeps 60 degrees. Where every cell holds a ray, nothing is asked, and both are alike.
///   table7/<case>_<n>k/<project|sort|bin|blend|frame>_<off|on>  ms
///   table7/<case>_<n>k/<...>_saved                              % of off
///   table7/<case>_<n>k/<particles|pairs>_removed            % of the visible ones
///   table7/<case>_<n>k/pairs_in_empty_tiles                 % of those left: what a test per tile could
///                                                               remove besides
///   table7/full_sweep_<n>k/particles_<beside|between>_the_beams % that the beams' own elevations drop in
///                                                               projection, without any mask
[[nodiscard]] std::vector<Row> run_table7(const std::string& device_request,
                                          std::int64_t particles,
                                          const Progress& note);

}  // namespace simuli::bench
