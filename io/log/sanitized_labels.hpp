#pragma once
// What labels say that cannot be.
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

/// Mends the log's labels, a line for each that is not as it was, empty where all are:
/// - Headings that jump by half a turn are turned back (a box has the same shape either way), so that they
///   agree with where the thing drives to or, where it stands, with most of its labels. One that is off by
///   another angle for one label is that between the labels beside it. What still turns faster than such a
///   thing can is told and left.
/// - A place that one label alone tells, where the thing can't have got to and come back from, is left out. What
///   else moves faster than anything on roads and rails is told and left.
/// - No other thing is where a sensor is, nor right below it: a label that is so at half of its poses and
///   more is the own vehicle or of no use and left out, and so are those poses of others.
/// - What drives and is wider than 5 m or longer than 30 m (tram, train: 400 m) is left out.
[[nodiscard]] std::vector<std::string> sanitize_labels(Log& log);

}  // namespace simuli
