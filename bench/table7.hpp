#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/lidar_frames.hpp"

namespace simuli::bench {

/// Table 7 of the paper: stages with and without ray-based culling, frames of both in turns, for a full
/// sweep, for 1 ray in 16 of it spread evenly, for every 16th firing, for every 16th beam, for an eighth of
/// the sweep, and for a sensor that sweeps 60 degrees. On the full sweep the query is forced: by default it
/// isn't asked.
///   table7/<case>_<n>k/<project|sort|bin|blend|frame>_<off|on>     ms
///   table7/<case>_<n>k/<...>_saved                                 % of off
///   table7/<case>_<n>k/<particles|instances>_removed               % of the visible ones
///   table7/<case>_<n>k/instances_in_empty_tiles                    % of those left: what a test per tile
///                                                                  could remove besides
[[nodiscard]] std::vector<Row> run_table7(const std::string& device_request,
                                          std::int64_t particles,
                                          const Progress& note);

}  // namespace simuli::bench
