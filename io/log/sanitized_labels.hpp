#pragma once
// Detection and repair of impossible labels.
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

/// Repairs the log's labels. Returns a line for each repaired label; empty if all are plausible:
/// - Headings that jump by half a revolution are reversed (a box has the same shape either way), so that they agree
///   with the direction of driving or, for an object at rest, with most of its labels. A single heading with another
///   error is interpolated between its neighbours. Objects that still turn too fast are reported and kept.
/// - A single position that the object cannot have reached and returned from is left out. Other motion faster than
///   anything on roads and rails is reported and kept.
/// - No other object is at a sensor or directly below it: a label with at least half of its poses there is the ego
///   vehicle or wrong and is left out; of other labels those poses are left out.
/// - A moving object wider than 5 m or longer than 30 m (tram, train: 400 m) is left out.
[[nodiscard]] std::vector<std::string> sanitize_labels(Log& log);

}  // namespace simuli
