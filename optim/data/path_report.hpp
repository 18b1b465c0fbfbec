#pragma once
// Report of the ego-pose refinement.
#include <cstddef>
#include <string>

namespace simuli {

/// Consistency of sweeps with common planes, with recorded and with refined ego poses.
struct PathReport {
  std::size_t sweeps = 0;  // sweeps used; 0: not requested, or not possible
  double recorded_m = 0.0, refined_m = 0.0;  // median distance from the planes
  double recorded_share = 0.0, refined_share = 0.0;  // share of returns on planes
  bool used = false;  // training uses the refined poses
  double largest_change_m = 0.0;  // largest change of a position, if used
  std::string reason;  // reason for not using them
  double seconds = 0.0;
};

}  // namespace simuli
