#pragma once
// What the refinement of a log's path says of itself.
#include <cstddef>
#include <string>

namespace simuli {

/// How well sweeps lie on common planes, on the path as recorded and as refined.
struct PathReport {
  std::size_t sweeps = 0;                            // looked at; 0: it was not asked for, or could not be
  double recorded_m = 0.0, refined_m = 0.0;          // median distance from the planes
  double recorded_share = 0.0, refined_share = 0.0;  // of returns, on planes
  bool used = false;                                 // the training is on the refined path
  double largest_change_m = 0.0;                     // of a position, where it is used
  std::string reason;                                // why it is not
  double seconds = 0.0;
};

}  // namespace simuli
