#pragma once
// What the refinement of a log's path is told, and what it says of itself.
#include <cstddef>
#include <string>

#include "host/base/allowed.hpp"

namespace simuli {

struct PathRefinement {
  bool refine = true;
  double position_m = 0.1;
  double rotation_deg = 0.2;
};

/// The keys that users set, with what is allowed and what it means (host/base/fields.hpp).
template <class F>
constexpr void visit_fields(PathRefinement& o, F&& field) {
  field("path.refine",
        o.refine,
        "the path on which sweeps agree best, where they agree better than as recorded");
  field("path.position_m", o.position_m, range(1e-3, 100.0), "m, standard deviation of recorded positions");
  field("path.rotation_deg",
        o.rotation_deg,
        range(1e-3, 180.0),
        "degrees, standard deviation of recorded rotations");
}

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
