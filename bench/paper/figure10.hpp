#pragma once
#include <string>
#include <vector>

#include "bench/paper/fit.hpp"
#include "bench/render/measure.hpp"

namespace simuli::bench {

struct Figure10Options {
  int iterations = 300;  // per training
  int frames = 20;
};

/// Figure 10 of the paper: thin poles along the street (1.6 to 4 cm wide), scanned by beams of 3 mrad that
/// return the nearest surface; a LiDAR set trained and rendered without the footprint filter, with it, and
/// with it and opacity compensation.
///   figure10/<none|filter|filter_compensated>/pole_error   median distance error of held-out rays on poles,
/// cm
///   figure10/<...>/pole_found                              share of these rays within 10 cm
///   figure10/<...>/all_error                               median distance error of all returns, cm
[[nodiscard]] std::vector<Row> run_figure10(const std::string& device_request,
                                            const Figure10Options& options,
                                            const Note& note);

}  // namespace simuli::bench
