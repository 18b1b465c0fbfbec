#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/render/lidar_frames.hpp"

namespace simuli::bench {

/// Table 7 of the paper: stages without ray-based culling, with the mask of the paper (on: 1599 x 8 cells)
/// and with what requested rays get by default (fine: a row per beam, two columns per firing), frames of all
/// in turns, for a full sweep, for 1 ray in 16 of it spread evenly, for every 16th firing, for every 16th
/// beam, for an eighth of the sweep, and for a sensor that sweeps 60 degrees. The query is forced: by default
/// it isn't asked where every cell holds a ray.
///   table7/<case>_<n>k/<project|sort|bin|blend|frame>_<off|on|fine>    ms
///   table7/<case>_<n>k/<...>_saved_<on|fine>                           % of off
///   table7/<case>_<n>k/<particles|instances>_removed_<on|fine>         % of the visible ones
///   table7/<case>_<n>k/instances_in_empty_tiles                        % of those left: what a test per tile
///                                                                      could remove besides
///   table7/full_sweep_<n>k/particles_<beside|between>_the_beams        % that the beams' own elevations drop
///   in
///                                                                      projection, without any mask
[[nodiscard]] std::vector<Row> run_table7(const std::string& device_request,
                                          std::int64_t particles,
                                          const Progress& note);

}  // namespace simuli::bench
